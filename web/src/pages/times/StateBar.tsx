import { useTranslation } from "react-i18next";
import type { MachineState, OeeRow } from "../../api/types";
import { hours } from "../../format/time";

const order: readonly MachineState[] = ["running", "hold", "stopped", "setup", "idle", "alarm", "emergency_stop", "off", "unknown"];

/// The scheduled time as one bar. What nobody knows is hatched: it is neither running nor standing.
export function StateBar({ row }: { row: OeeRow }) {
  const { t } = useTranslation();
  if (row.scheduled_s <= 0) return <span className="dim">{t("times.not_scheduled")}</span>;
  const parts = order.map((state) => ({ state, s: state === "unknown" ? row.unknown_s : row.states[state] ?? 0 })).filter((part) => part.s > 0);
  return (
    <div className="state-bar" role="img" aria-label={parts.map((part) => `${t(`state.${part.state}`)} ${hours(part.s)}`).join(", ")}>
      {parts.map((part) => (
        <span key={part.state} className={`state-${part.state}`} style={{ width: `${(part.s / row.scheduled_s) * 100}%` }} title={`${t(`state.${part.state}`)} ${hours(part.s)}`} />))}
    </div>
  );
}

export function StateLegend() {
  const { t } = useTranslation();
  return <div className="state-legend">{order.map((state) => <span key={state}><i className={`state-${state}`} />{t(`state.${state}`)}</span>)}</div>;
}
