// What is to be sent at a time: it waits for the control from then on. A person may take it back.
import { useTranslation } from "react-i18next";
import { remove } from "../../api/client";
import { moment } from "../../format/time";
import { reasonText } from "../../i18n";
import { useMay } from "../../shell/session";
import { Button, useAction } from "../../ui/parts";
import type { Plan } from "./types";

const tone: Record<string, string> = { planned: "info", started: "good", missed: "bad", refused: "bad" };

export function PlanLine({ plan, onChanged }: { plan: Plan; onChanged: () => void }) {
  const { t } = useTranslation();
  const operator = useMay("operator");
  const { busy, run } = useAction();
  return (
    <div className="port-queue" data-plan={plan.id} data-state={plan.state}>
      <span className={`chip ${tone[plan.state] ?? ""}`}>{t(`dnc.plan_${plan.state}`)}</span>
      <span>{moment(plan.at)} · <b>{plan.name}</b> {t("programs.revision_n", { number: plan.revision })}{plan.drip ? ` · ${t("dnc.kind_drip")}` : ""}{plan.from_line > 1 ? ` · ${t("dnc.from_line", { line: plan.from_line })}` : ""} · {plan.by}</span>
      {plan.reason && <span className="dim">{reasonText(plan.reason)}</span>}
      {operator && plan.state === "planned" && <Button small kind="quiet" icon="close" busy={busy} data-action="unplan" aria-label={t("common.remove")} onClick={() => run(async () => { await remove(`/port-plans/${plan.id}`); onChanged(); })} />}
    </div>
  );
}
