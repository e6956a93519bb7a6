// Which alarms cost most: how often, how long, on how many machines.
import { useTranslation } from "react-i18next";
import { list, query } from "../api/client";
import type { AlarmFigure } from "../api/types";
import { hours, moment } from "../format/time";
import { inLanguage } from "../i18n";
import { useLoad } from "../live/hooks";
import { CsvLink, ErrorNote } from "../ui/parts";

export function AlarmStatistics({ machine, from, to, onCode }: { machine: string | null; from: string | null; to: string | null; onCode: (code: string) => void }) {
  const { t } = useTranslation();
  const { value, error } = useLoad((signal) => list<AlarmFigure>(`/alarms/statistics${query({ machine, from: from ?? "1970-01-02", to })}`, signal), [machine, from, to]);
  const most = Math.max(1, ...(value ?? []).map((one) => one.active_s));
  return (
    <>
      <ErrorNote error={error} />
      <div className="table-tools"><CsvLink path={`/alarms/statistics${query({ machine, from: from ?? "1970-01-02", to })}`} /></div>
      <table className="table alarms">
        <thead><tr><th>{t("alarms.code")}</th><th>{t("alarms.text")}</th><th className="right">{t("alarms.times")}</th><th className="right">{t("alarms.machines")}</th><th className="right">{t("alarms.duration")}</th><th className="bar-cell" /><th>{t("alarms.last")}</th></tr></thead>
        <tbody>{(value ?? []).map((one) => (
          <tr key={one.code} data-alarm={one.code}>
            <td className="mono code"><button type="button" className="as-link" onClick={() => onCode(one.code)}>{one.code}</button></td><td className="grow">{inLanguage(one.text)}</td>
            <td className="num right">{one.count}</td><td className="num right">{one.machines}</td><td className="num right">{hours(one.active_s)}</td>
            <td className="bar-cell"><span className="bar" style={{ width: `${(one.active_s / most) * 100}%` }} /></td><td className="num">{moment(one.last).slice(0, 16)}</td>
          </tr>))}</tbody>
      </table>
      {value?.length === 0 && <div className="empty">{t("alarms.none")}</div>}
    </>
  );
}
