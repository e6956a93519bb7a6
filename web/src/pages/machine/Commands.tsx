// Start, hold and reset. Hold acts at once, always; what starts motion asks first. A refusal is shown in words.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { ApiError, post } from "../../api/client";
import { reasonText } from "../../i18n";
import type { Seen } from "../../live/hooks";
import { useMay } from "../../shell/session";
import { Button, Dialog, toast, useAction } from "../../ui/parts";
import { StateIcon } from "../../ui/icons";

interface Answer { accepted: boolean; reason: string | null }

/// Sends one command and says what became of it. @return whether the machine took it.
export function useCommand(id: number, name: string) {
  const { t } = useTranslation();
  return async (action: string, value?: number, quiet?: boolean): Promise<boolean> => {
    const spoken = t(`command.${action}`, { defaultValue: action });
    try {
      const answer = await post<Answer>(`/machines/${id}/commands`, value === undefined ? { action } : { action, value });
      if (answer.accepted === false) {
        toast("error", t("command.refused", { name, action: spoken, reason: reasonText(answer.reason) }));
        return false;
      }
      if (!quiet) toast("good", t("command.accepted", { name, action: spoken }));
      return true;
    } catch (error) {
      if (error instanceof ApiError && error.status === 409) {
        const reason = error.reason ?? error.code;
        const said = reasonText(reason);
        toast("error", t("command.refused", { name, action: spoken, reason: said === reason && error.text ? (error.text[document.documentElement.lang === "zh-CN" ? "zh" : "en"]) : said }));
        return false;
      }
      throw error;
    }
  };
}

export function Commands({ id, name, seen }: { id: number; name: string; seen: Seen }) {
  const { t } = useTranslation();
  const may = useMay("operator");
  const command = useCommand(id, name);
  const { busy, run } = useAction();
  const [asking, setAsking] = useState<"cycle_start" | "reset" | null>(null);
  const { live, state, current } = seen;
  const answered = (action: "cycle_start" | "reset") => { setAsking(null); run(async () => { await command(action); }); };
  return (
    <div className="commands" title={may ? undefined : t("command.need_role")}>
      <Button kind="go" disabled={!may || !current} busy={busy} data-command="cycle_start" onClick={() => setAsking("cycle_start")}><StateIcon state="running" />{t("command.cycle_start")}</Button>
      <Button kind="hold" disabled={!may} data-command="feed_hold" onClick={() => run(async () => { await command("feed_hold"); })}><StateIcon state="hold" />{t("command.feed_hold")}</Button>
      <Button disabled={!may} busy={busy} data-command="reset" onClick={() => (state === "running" || state === "hold" ? setAsking("reset") : answered("reset"))}>{t("command.reset")}</Button>
      {asking && (
        <Dialog name="confirm" title={t(asking === "cycle_start" ? "command.confirm_start_title" : "command.confirm_reset_title", { name })} onClose={() => setAsking(null)} actions={<>
          <Button autoFocus onClick={() => setAsking(null)}>{t("common.cancel")}</Button>
          <Button kind={asking === "cycle_start" ? "go" : "danger"} data-confirm={asking} onClick={() => answered(asking)}>{t(`command.${asking}`)}</Button></>}>
          {asking === "cycle_start" && (
            <dl className="facts"><dt>{t("machine.program")}</dt><dd><b>{live?.program?.name ?? t("common.no_program")}</b>{live?.program?.revision ? ` · ${t("programs.revision_n", { number: live.program.revision })}` : ""}</dd>
              <dt>{t("override.title")}</dt><dd className="num">F {live?.overrides?.feed ?? "—"} % · R {live?.overrides?.rapid ?? "—"} % · S {live?.overrides?.spindle ?? "—"} %</dd></dl>)}
          <p>{t(asking === "cycle_start" ? "command.confirm_start" : "command.confirm_reset")}</p>
          {asking === "cycle_start" && live?.remote_armed === false && <div className="note warn"><span>{reasonText("not_armed")}</span></div>}
        </Dialog>
      )}
    </div>
  );
}
