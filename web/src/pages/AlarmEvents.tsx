// Events of the alarm rules: one for an alarm that stays or comes back, acknowledged by a person with a name.
import { useTranslation } from "react-i18next";
import { list, post, query } from "../api/client";
import type { Localised } from "../api/types";
import { moment } from "../format/time";
import { inLanguage } from "../i18n";
import { useLoad, useShop } from "../live/hooks";
import { address } from "../shell/router";
import { useMay } from "../shell/session";
import { Button, CsvLink, ErrorNote, useAction } from "../ui/parts";

interface AlarmEvent {
  id: number; rule: string; machine: number; machine_name: string; code: string; text: Localised; first: string; last: string; times: number;
  cleared: string | null; escalated: string | null; acknowledged: { at: string; by: string; note: string } | null;
}

export function AlarmEvents({ machine }: { machine: string | null }) {
  const { t } = useTranslation();
  const may = useMay("operator");
  const seen = useShop((shop) => shop.alarmsSeen);
  const { value: events, error, reload } = useLoad((signal) => list<AlarmEvent>(`/alarm-events${query({ machine, limit: 200 })}`, signal), [machine, seen]);
  const { busy, run } = useAction();
  return (
    <>
      <ErrorNote error={error} />
      <div className="table-tools"><CsvLink path={`/alarm-events${query({ machine })}`} /></div>
      <table className="table alarms">
        <thead><tr><th>{t("alarms.raised")}</th><th>{t("alarms.machine")}</th><th>{t("alarms.code")}</th><th>{t("alarms.text")}</th><th>{t("rules.times")}</th><th>{t("rules.rule")}</th><th>{t("rules.acknowledged")}</th></tr></thead>
        <tbody>{(events ?? []).map((event) => (
          <tr key={event.id} className={event.cleared ? "" : "active"} data-event={event.id}>
            <td className="num">{moment(event.first)}</td><td><a href={address(["machines", event.machine])}>{event.machine_name}</a></td>
            <td className="mono code">{event.code}</td><td className="grow">{inLanguage(event.text)}</td><td className="num">{event.times}</td>
            <td>{event.rule}{event.escalated && <span className="chip alarm">{t("rules.escalated")}</span>}</td>
            <td>{event.acknowledged ? `${event.acknowledged.by}, ${moment(event.acknowledged.at)}`
              : may ? <Button small busy={busy} onClick={() => run(async () => { await post(`/alarm-events/${event.id}/acknowledge`); reload(); })}>{t("rules.acknowledge")}</Button> : "–"}</td>
          </tr>
        ))}</tbody>
      </table>
      {events?.length === 0 && <div className="empty">{t("rules.no_events")}</div>}
    </>
  );
}
