import { lazy, Suspense, useEffect, useState } from "react";
import { useTranslation } from "react-i18next";
import type { Backplot } from "../api/types";
import { chosenTheme } from "../shell/theme";
import { Button } from "../ui/parts";
import { LathePath } from "./LathePath";
import type { Look } from "./MillPath";
import { isLathe, type Trail } from "./plot";

const MillPath = lazy(() => import("./MillPath").then((m) => ({ default: m.MillPath })));

function useTheme(): string {
  const [theme, set] = useState<string>(chosenTheme());
  useEffect(() => {
    const observer = new MutationObserver(() => set(document.documentElement.dataset["theme"] ?? "dark"));
    observer.observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
    return () => observer.disconnect();
  }, []);
  return theme;
}

export function PathView({ axes, plot, trail, trailVersion, tool, line }: {
  axes: string[]; plot: Backplot | null; trail?: Trail; trailVersion?: number; tool?: number[] | null; line?: number | null;
}) {
  const { t } = useTranslation();
  const theme = useTheme();
  const [fitted, setFitted] = useState(0);
  const [look, setLook] = useState<Look>("iso");
  const turning = isLathe(axes);
  const same = { plot, trail, trailVersion, tool, toolAxes: axes, line, theme, fitted };
  return (
    <div className="path-view">
      <div className="path-tools">
        {!turning && (["iso", "top", "front"] as const).map((one) => (
          <Button key={one} small kind="quiet" aria-pressed={look === one} onClick={() => { setLook(one); setFitted((n) => n + 1); }}>{t(`machine.view_${one}`)}</Button>))}
        <Button small kind="quiet" onClick={() => setFitted((n) => n + 1)}>{t("machine.fit")}</Button>
      </div>
      {turning ? <LathePath {...same} /> : <Suspense fallback={<div className="waiting">{t("common.loading")}</div>}><MillPath {...same} look={look} /></Suspense>}
      <div className="path-legend">
        <span><i className="rapid" />{t("machine.path_rapid")}</span><span><i className="cut" />{t("machine.path_cut")}</span>
        {trail && <span><i className="done" />{t("machine.path_done")}</span>}
        {tool && <span><i className="tool" />{t("machine.path_tool")}</span>}
        {plot?.truncated && <em>{t("machine.path_truncated")}</em>}
      </div>
    </div>
  );
}
