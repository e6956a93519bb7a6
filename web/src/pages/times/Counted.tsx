import { useTranslation } from "react-i18next";
import { list } from "../../api/client";
import type { DowntimeReason, OeeRow } from "../../api/types";
import { percent, unknownText } from "../../format/number";
import { hours } from "../../format/time";
import { inLanguage } from "../../i18n";
import { useLoad } from "../../live/hooks";

/// Every figure as the division it is.
export function Counted({ row }: { row: OeeRow }) {
  const { t } = useTranslation();
  const { value: reasons } = useLoad((signal) => list<DowntimeReason>("/downtime-reasons", signal), []);
  const names = new Map((reasons ?? []).map((reason) => [reason.id, inLanguage(reason.name)]));
  const figure = (value: number | null) => value === null ? unknownText : percent(value, 1);
  return (
    <dl className="facts counted">
      <dt>{t("times.scheduled")}</dt><dd className="num">{hours(row.scheduled_s)}</dd>
      <dt>{t("times.minus_planned")}</dt><dd className="num">{hours(row.planned_stop_s)}</dd>
      <dt>{t("times.minus_unknown")}</dt><dd className="num">{hours(row.unknown_s)}</dd>
      <dt>{t("times.planned")}</dt><dd className="num">{hours(row.planned_s)}</dd>
      <dt>{t("times.availability")}</dt><dd className="num"><b>{figure(row.availability)}</b> = {hours(row.states.running ?? 0)} ÷ {hours(row.planned_s)}</dd>
      <dt>{t("times.performance")}</dt><dd className="num"><b>{figure(row.performance)}</b> = {hours(row.ideal_s)} ÷ {hours(row.states.running ?? 0)}
        {row.parts_without_ideal > 0 && <span className="why">{t("times.without_ideal", { parts: row.parts_without_ideal })}</span>}</dd>
      <dt>{t("times.quality")}</dt><dd className="num"><b>{figure(row.quality)}</b> = {row.parts - row.rejects} ÷ {row.parts}</dd>
      <dt>OEE</dt><dd className="num"><b>{figure(row.oee)}</b></dd>
      {row.reasons.map((one) => <FragmentRow key={one.reason} name={names.get(one.reason) ?? `${one.reason}`} s={one.s} />)}
      {row.unexplained_s > 0 && <FragmentRow name={t("times.unexplained")} s={row.unexplained_s} />}
    </dl>
  );
}

function FragmentRow({ name, s }: { name: string; s: number }) {
  return <><dt className="stop-of">{name}</dt><dd className="num">{hours(s)}</dd></>;
}
