// What the machines did with the shop's time: one row a machine, its states as a bar, the four figures; and for one
// machine what was counted for them, the days, and its stops with their reasons.
import { useMemo, useState } from "react";
import { useTranslation } from "react-i18next";
import { list, query } from "../../api/client";
import type { Machine, OeeRow } from "../../api/types";
import { hours } from "../../format/time";
import { percent, unknownText } from "../../format/number";
import { useLoad } from "../../live/hooks";
import { address, swap, useRoute } from "../../shell/router";
import { useMay } from "../../shell/session";
import { Button, CsvLink, ErrorNote, Panel, Tabs } from "../../ui/parts";
import { Counted } from "./Counted";
import { ShiftsDialog } from "./Shifts";
import { StateBar, StateLegend } from "./StateBar";
import { Stops } from "./Stops";
import { PartsAgainstTarget, Timeline } from "./Timeline";
import { targetParts } from "./timeline";

const periods = ["today", "yesterday", "7d", "30d"] as const;
type Period = (typeof periods)[number];
const groups = ["day", "shift"] as const;

/// Whole days of the person who looks; the last one ends now.
export function spanOf(period: Period, now: Date): { from: string; to: string } {
  const midnight = new Date(now.getFullYear(), now.getMonth(), now.getDate());
  const daysBefore = (days: number) => new Date(now.getFullYear(), now.getMonth(), now.getDate() - days);
  const spans: Record<Period, [Date, Date]> = {
    today: [midnight, now], yesterday: [daysBefore(1), midnight], "7d": [daysBefore(6), now], "30d": [daysBefore(29), now],
  };
  const [from, to] = spans[period];
  return { from: from.toISOString(), to: to.toISOString() };
}

export function Times() {
  const { t } = useTranslation();
  const route = useRoute();
  const asked = route.search.get("period") as Period | null;
  const period: Period = asked && periods.includes(asked) ? asked : "today";
  const chosen = route.parts[1] ? Number(route.parts[1]) : null;
  const group = route.search.get("by") === "shift" ? "shift" : "day";
  const span = useMemo(() => spanOf(period, new Date()), [period]);
  const { value: machines } = useLoad((signal) => list<Machine>("/machines", signal), []);
  const { value: rows, error, reload } = useLoad((signal) => list<OeeRow>(`/oee${query(span)}`, signal), [span]);
  const { value: pieces, reload: reloadPieces } = useLoad(async (signal) => chosen === null ? null : list<OeeRow>(`/oee${query({ ...span, machine: chosen, by: group })}`, signal), [span, chosen, group]);
  const setter = useMay("setter");
  const [settings, setSettings] = useState(false);
  const names = new Map((machines ?? []).map((machine) => [machine.id, machine.name]));
  const to = (machine: number | null, change: Record<string, string | null> = {}) =>
    address(machine === null ? ["times"] : ["times", machine], { period, by: route.search.get("by"), ...change });
  const most = Math.max(1, ...(pieces ?? []).flatMap((piece) => [piece.parts, targetParts(piece) ?? 0]));
  const row = chosen === null ? undefined : rows?.find((one) => one.machine === chosen);

  return (
    <div className="page" data-page="times">
      <div className="page-bar"><h1>{t("nav.times")}</h1>
        <Tabs label={t("times.period")} value={period} onChange={(value) => swap(to(chosen, { period: value }))}
          options={periods.map((value) => ({ value, text: t(`times.${value}`) }))} />
        <span className="bar-end">{setter && <Button icon="edit" data-action="shifts" onClick={() => setSettings(true)}>{t("times.settings")}</Button>}
          <CsvLink path={`/oee${query(span)}`} /></span></div>
      {settings && <ShiftsDialog onClose={() => setSettings(false)} onChanged={() => { reload(); reloadPieces(); }} />}
      <ErrorNote error={error} />
      <Panel className="flush">
        <table className="table times">
          <thead><tr><th>{t("alarms.machine")}</th><th className="bar-column">{t("times.states")}</th>
            <th className="right" title={t("times.oee_explained")}>OEE</th><th className="right">{t("times.availability")}</th><th className="right">{t("times.performance")}</th><th className="right">{t("times.quality")}</th>
            <th className="right">{t("times.parts")}</th><th className="right">{t("times.rejects")}</th><th className="right">{t("times.unexplained")}</th></tr></thead>
          <tbody>
            {(rows ?? []).map((one) => (
              <tr key={one.machine} data-machine={one.machine} aria-selected={one.machine === chosen}>
                <td><a href={one.machine === chosen ? to(null) : to(one.machine)}>{names.get(one.machine) ?? one.machine}</a></td>
                <td className="bar-column"><StateBar row={one} /></td>
                <Figure value={one.oee} strong /><Figure value={one.availability} /><Figure value={one.performance} /><Figure value={one.quality} />
                <td className="num right">{one.parts}</td><td className="num right">{one.rejects || ""}</td>
                <td className={`num right${one.unexplained_s >= 600 ? " wants" : ""}`}>{one.unexplained_s > 0 ? hours(one.unexplained_s) : ""}</td>
              </tr>))}
          </tbody>
        </table>
        {rows?.length === 0 && <div className="empty">{t("times.none")}</div>}
      </Panel>
      <StateLegend />
      {chosen !== null && row && (
        <div className="times-detail">
          <Panel name="counted" title={t("times.counted", { machine: names.get(chosen) ?? chosen })}><Counted row={row} /></Panel>
          <Panel name="pieces" extra={<CsvLink path={`/oee${query({ ...span, machine: chosen, by: group })}`} />} title={<Tabs label={t("times.group")} value={group} onChange={(value) => swap(to(chosen, { by: value }))}
            options={groups.map((value) => ({ value, text: t(`times.by_${value}`) }))} />}>
            <table className="table times"><thead><tr><th /><th className="bar-column">{t("times.states")}</th><th className="right">OEE</th><th className="parts-column">{t("times.parts_target")}</th><th className="right">{t("times.parts")}</th></tr></thead><tbody>
              {(pieces ?? []).map((piece) => (
                <tr key={piece.from}><td className="num">{piece.day}{piece.shift ? ` ${piece.shift}` : ""}</td><td className="bar-column"><StateBar row={piece} /></td>
                  <Figure value={piece.oee} strong />
                  <td className="parts-column"><PartsAgainstTarget row={piece} most={most} /></td><td className="num right">{piece.parts}<span className="dim"> / {targetParts(piece) ?? unknownText}</span></td></tr>))}
            </tbody></table>
            {pieces?.length === 0 && <div className="empty small">{t("times.no_shift")}</div>}
          </Panel>
          <Timeline machine={chosen} span={span} />
          <Stops machine={chosen} span={span} onChanged={() => { reload(); reloadPieces(); }} />
        </div>
      )}
      {chosen === null && rows && rows.length > 0 && <p className="dim">{t("times.choose")}</p>}
    </div>
  );
}

function Figure({ value, strong }: { value: number | null; strong?: boolean }) {
  const text = value === null ? unknownText : percent(value, 1);
  return <td className="num right">{strong ? <b>{text}</b> : text}</td>;
}
