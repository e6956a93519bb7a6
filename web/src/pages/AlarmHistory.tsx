import { useEffect, useState } from "react";
import { useTranslation } from "react-i18next";
import { list, page, query } from "../api/client";
import type { AlarmRecord, Machine } from "../api/types";
import { duration, moment } from "../format/time";
import { inLanguage } from "../i18n";
import { useLoad, useShop } from "../live/hooks";
import { address, swap, useRoute } from "../shell/router";
import { Button, CsvLink, ErrorNote, Panel, Tabs } from "../ui/parts";
import { AlarmEvents } from "./AlarmEvents";
import { AlarmStatistics } from "./AlarmStatistics";

const filters = ["machine", "from", "to", "code", "q", "active"] as const;
const periods = { "24h": 1, "7d": 7, "30d": 30 } as const;

const raisedAt = (alarm: AlarmRecord) => alarm.since ?? alarm.raised ?? alarm.at ?? null;
const utc = (local: string | null) => (local ? new Date(local).toISOString() : null);

export function AlarmHistory() {
  const { t } = useTranslation();
  const route = useRoute();
  const seen = useShop((shop) => shop.alarmsSeen);
  const { value: machines } = useLoad((signal) => list<Machine>("/machines", signal), []);
  const chosen = Object.fromEntries(filters.map((name) => [name, route.search.get(name)])) as Record<(typeof filters)[number], string | null>;
  const path = (cursor?: string) => `/alarms${query({ ...chosen, from: utc(chosen.from), to: utc(chosen.to), cursor, limit: 200 })}`;
  const { value: first, error } = useLoad((signal) => page<AlarmRecord>(path(), signal), [route.search.toString(), seen]);
  const [more, setMore] = useState<AlarmRecord[]>([]);
  const [next, setNext] = useState<string | null>(null);
  useEffect(() => { setMore([]); setNext(first?.next ?? null); }, [first]);
  const [text, setText] = useState({ code: chosen.code ?? "", q: chosen.q ?? "" });

  const asked = route.search.get("view");
  const view = asked === "statistics" || asked === "events" ? asked : "list";
  const set = (change: Partial<Record<(typeof filters)[number], string | null>>) => swap(address(["alarms"], { ...chosen, ...change, view: view === "list" ? null : view }));
  const local = (t0: Date) => new Date(t0.getTime() - t0.getTimezoneOffset() * 60_000).toISOString().slice(0, 16);
  const names = new Map((machines ?? []).map((machine) => [machine.id, machine.name]));
  const rows = [...(first?.items ?? []), ...more];
  const filtered = filters.some((name) => chosen[name]);

  return (
    <div className="page" data-page="alarms">
      <h1>{t("nav.alarms")}</h1>
      <form className="filters" onSubmit={(event) => { event.preventDefault(); set({ code: text.code.trim() || null, q: text.q.trim() || null }); }}>
        <label><span>{t("alarms.machine")}</span>
          <select name="machine" value={chosen.machine ?? ""} onChange={(event) => set({ machine: event.target.value || null })}>
            <option value="">{t("alarms.every_machine")}</option>
            {(machines ?? []).map((machine) => <option key={machine.id} value={machine.id}>{machine.name}</option>)}
          </select></label>
        <label><span>{t("alarms.from")}</span><input type="datetime-local" value={chosen.from ?? ""} onChange={(event) => set({ from: event.target.value || null })} /></label>
        <label><span>{t("alarms.to")}</span><input type="datetime-local" value={chosen.to ?? ""} onChange={(event) => set({ to: event.target.value || null })} /></label>
        <div className="quick" role="group" aria-label={t("alarms.period")}>
          {Object.entries(periods).map(([name, days]) => (
            <Button key={name} small kind="quiet" onClick={() => set({ from: local(new Date(Date.now() - days * 86_400_000)), to: null })}>{t(`alarms.last_${name}`)}</Button>
          ))}
        </div>
        <label><span>{t("alarms.code")}</span><input name="code" className="short mono" value={text.code} onChange={(event) => setText({ ...text, code: event.target.value })}
          onBlur={() => set({ code: text.code.trim() || null })} /></label>
        <label><span>{t("alarms.text")}</span><input name="q" value={text.q} onChange={(event) => setText({ ...text, q: event.target.value })}
          onBlur={() => set({ q: text.q.trim() || null })} /></label>
        <label className="check"><input type="checkbox" name="active" checked={chosen.active === "true"} onChange={(event) => set({ active: event.target.checked ? "true" : null })} />{t("alarms.active_only")}</label>
        <button type="submit" className="visually-hidden">{t("common.apply")}</button>
        {view === "list" && <CsvLink path={`/alarms${query({ ...chosen, from: utc(chosen.from), to: utc(chosen.to) })}`} />}
        {filtered && <Button small kind="quiet" icon="close" onClick={() => { setText({ code: "", q: "" }); swap(address(["alarms"])); }}>{t("alarms.clear")}</Button>}
      </form>
      <Tabs label={t("alarms.view")} value={view} onChange={(value) => swap(address(["alarms"], { ...chosen, view: value === "list" ? null : value }))}
        options={[{ value: "list", text: t("alarms.list") }, { value: "statistics", text: t("alarms.statistics") }, { value: "events", text: t("rules.events") }]} />
      {view === "events" && <Panel className="flush"><AlarmEvents machine={chosen.machine} /></Panel>}
      {view === "statistics" && <Panel className="flush"><AlarmStatistics machine={chosen.machine} from={utc(chosen.from)} to={utc(chosen.to)} onCode={(code) => swap(address(["alarms"], { ...chosen, code }))} /></Panel>}
      {view === "list" && <>
      <ErrorNote error={error} />
      <Panel className="flush">
        <table className="table alarms">
          <thead><tr><th>{t("alarms.raised")}</th><th>{t("alarms.machine")}</th><th>{t("alarms.code")}</th><th>{t("alarms.text")}</th><th>{t("alarms.program")}</th><th>{t("alarms.duration")}</th></tr></thead>
          <tbody>
            {rows.map((alarm) => {
              const since = raisedAt(alarm);
              const lasted = alarm.cleared && since ? (Date.parse(alarm.cleared) - Date.parse(since)) / 1000 : null;
              return (
                <tr key={`${alarm.machine}-${alarm.id}`} className={alarm.cleared ? "" : "active"} data-alarm={alarm.code}>
                  <td className="num">{moment(since)}</td>
                  <td><a href={address(["machines", alarm.machine])}>{names.get(alarm.machine) ?? alarm.machine}</a></td>
                  <td className="mono code">{alarm.code}</td>
                  <td className="grow">{inLanguage(alarm.text)}{alarm.block && <span className="block mono">{alarm.block}</span>}</td>
                  <td className="mono">{alarm.program}{alarm.line ? ` : ${alarm.line}` : ""}</td>
                  <td className="num">{alarm.cleared ? duration(lasted) : <span className="chip alarm">{t("alarms.active")}</span>}</td>
                </tr>
              );
            })}
          </tbody>
        </table>
        {first && rows.length === 0 && <div className="empty">{t(filtered ? "alarms.none_filtered" : "alarms.none")}</div>}
      </Panel>
      {next && <Button onClick={() => { void page<AlarmRecord>(path(next)).then((got) => { setMore([...more, ...got.items]); setNext(got.next); }); }}>{t("common.more")}</Button>}
      </>}
    </div>
  );
}
