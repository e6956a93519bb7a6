// Below the live part: what is resident in the machine, what it ran, its alarms, its data.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { get, list, page, patch, post, remove } from "../../api/client";
import type { AlarmRecord, Machine, Resident } from "../../api/types";
import { bytes, unknownText } from "../../format/number";
import { duration, moment } from "../../format/time";
import { errorText, inLanguage, reasonText } from "../../i18n";
import { useLoad, useShop, type Seen } from "../../live/hooks";
import { address, go } from "../../shell/router";
import { useMay } from "../../shell/session";
import { Button, CsvLink, Dialog, ErrorNote, Field, Panel, Tabs, toast, useAction } from "../../ui/parts";
import { TokenDialog } from "../AddMachine";

type Tab = "resident" | "runs" | "alarms" | "data";
interface Run { id: number; program: string | null; revision?: number | null; started: string; ended: string | null; outcome: string | null; run_s: number | null; cutting_s?: number | null; parts?: number | null; holds?: number | null; overrides?: { feed?: [number, number] } | null; by?: string | null }

export function MachineRecords({ id, seen, machine, onChanged }: { id: number; seen: Seen; machine: Machine | undefined; onChanged: () => void }) {
  const { t } = useTranslation();
  const [tab, setTab] = useState<Tab>("resident");
  return (
    <Panel className="records" name="records">
      <Tabs label={t("machine.history")} value={tab} onChange={setTab} options={[
        { value: "resident", text: t("machine.resident") }, { value: "runs", text: t("machine.runs") },
        { value: "alarms", text: t("nav.alarms") }, { value: "data", text: t("machine.data") }]} />
      {tab === "resident" && <Census id={id} seen={seen} />}
      {tab === "runs" && <Runs id={id} />}
      {tab === "alarms" && <Alarms id={id} />}
      {tab === "data" && machine && <Data machine={machine} onChanged={onChanged} />}
    </Panel>
  );
}

function Census({ id, seen }: { id: number; seen: Seen }) {
  const { t } = useTranslation();
  const operator = useMay("operator");
  const changed = useShop((shop) => [...shop.transfers.values()].filter((one) => one.machine === id && one.state === "done").length);
  const programs = useShop((shop) => shop.programsSeen);
  const { value, error, reload } = useLoad((signal) => list<Resident>(`/machines/${id}/programs`, signal), [id, changed, programs, seen.live?.program?.name]);
  const { busy, run } = useAction();
  const select = (name: string) => run(async () => {
    try {
      const answer = await post<{ accepted?: boolean; reason?: string }>(`/machines/${id}/select`, { name });
      if (answer?.accepted === false) toast("error", reasonText(answer.reason));
      else toast("good", t("machine.selected", { name }));
    } catch (problem) { toast("error", errorText(problem)); }
    reload();
  });
  return (
    <div className="table-box">
      <ErrorNote error={error} />
      <div className="records-bar"><a className="button small" href={address(["programs"])}>{t("machine.send")}</a><Button small kind="quiet" onClick={reload}>{t("common.refresh")}</Button><CsvLink path={`/machines/${id}/programs`} /></div>
      <table className="table"><thead><tr><th>{t("machine.program")}</th><th>{t("programs.revision")}</th><th /><th>{t("machine.resident_since")}</th><th className="right">{t("programs.column_size")}</th><th /></tr></thead>
        <tbody>{(value ?? []).map((one) => {
          const library = one.program_id ?? (typeof one.program === "number" ? one.program : null);
          const selected = seen.live?.program?.name === one.name || one.selected;
          return (
            <tr key={one.name} data-resident={one.name} aria-selected={selected}>
              <td><b>{library ? <a href={address(["programs", library], { rev: one.revision })}>{one.name}</a> : one.name}</b></td>
              <td>{one.revision ? t("programs.revision_n", { number: one.revision }) : unknownText}</td>
              <td>{one.revision === null || one.revision === undefined ? <span className="chip">{t("machine.resident_foreign")}</span>
                : one.stale ? <span className="chip warn" title={t("machine.resident_stale_title")}>{t("machine.resident_stale")}</span> : <span className="chip good">{t("machine.resident_current")}</span>}</td>
              <td className="num">{moment(one.since)}</td><td className="num right">{bytes(one.bytes)}</td>
              <td className="row-actions">{selected ? <span className="chip info">{t("machine.resident_selected")}</span>
                : <Button small disabled={!operator || !seen.current} busy={busy} data-select={one.name} onClick={() => select(one.name)}>{t("machine.select")}</Button>}</td>
            </tr>);
        })}</tbody></table>
      {value?.length === 0 && <div className="empty small">{t("machine.resident_none")}</div>}
    </div>
  );
}

const feedRange = (range: [number, number] | undefined) => (!range ? unknownText : range[0] === range[1] ? `${range[0]} %` : `${range[0]}–${range[1]} %`);

function Runs({ id }: { id: number }) {
  const { t } = useTranslation();
  const parts = useShop((shop) => shop.partsSeen);
  const { value, error } = useLoad((signal) => page<Run>(`/machines/${id}/runs?limit=50`, signal), [id, parts]);
  return (
    <div className="table-box">
      <ErrorNote error={error} />
      <div className="records-bar"><CsvLink path={`/machines/${id}/runs`} /></div>
      <table className="table"><thead><tr><th>{t("machine.run_started")}</th><th>{t("machine.program")}</th><th>{t("machine.run_outcome")}</th><th className="right">{t("machine.run_duration")}</th><th className="right">{t("machine.cutting_time")}</th><th className="right">{t("machine.parts")}</th><th className="right">{t("machine.run_holds")}</th><th className="right">{t("machine.run_overrides")}</th><th>{t("machine.run_by")}</th></tr></thead>
        <tbody>{(value?.items ?? []).map((one) => (
          <tr key={one.id}><td className="num">{moment(one.started)}</td><td>{one.program}</td>
            <td><span className={`chip ${one.outcome === "completed" ? "good" : one.outcome === "alarm" ? "bad" : ""}`}>{t(`outcome.${one.outcome ?? "running"}`, { defaultValue: one.outcome ?? "" })}</span></td>
            <td className="num right">{duration(one.run_s)}</td><td className="num right">{duration(one.cutting_s)}</td>
            <td className="num right">{one.parts ?? unknownText}</td><td className="num right">{one.holds ?? unknownText}</td><td className="num right">{feedRange(one.overrides?.feed)}</td><td>{one.by ?? ""}</td></tr>))}</tbody></table>
      {value?.items.length === 0 && <div className="empty small">{t("machine.runs_none")}</div>}
    </div>
  );
}

function Alarms({ id }: { id: number }) {
  const { t } = useTranslation();
  const seen = useShop((shop) => shop.alarmsSeen);
  const { value, error } = useLoad((signal) => page<AlarmRecord>(`/alarms?machine=${id}&limit=20`, signal), [id, seen]);
  return (
    <div className="table-box">
      <ErrorNote error={error} />
      <table className="table alarms"><thead><tr><th>{t("alarms.raised")}</th><th>{t("alarms.code")}</th><th>{t("alarms.text")}</th><th>{t("alarms.program")}</th><th /></tr></thead>
        <tbody>{(value?.items ?? []).map((one) => (
          <tr key={one.id} className={one.cleared ? "" : "active"}><td className="num">{moment(one.since ?? one.raised ?? one.at)}</td><td className="mono code">{one.code}</td><td className="grow">{inLanguage(one.text)}</td>
            <td className="mono">{one.program}{one.line ? ` : ${one.line}` : ""}</td><td>{!one.cleared && <span className="chip alarm">{t("alarms.active")}</span>}</td></tr>))}</tbody></table>
      {value?.items.length === 0 && <div className="empty small">{t("alarms.none")}</div>}
      <div className="records-bar"><a className="button small" href={address(["alarms"], { machine: id })}>{t("common.more")}</a></div>
    </div>
  );
}

function Data({ machine, onChanged }: { machine: Machine; onChanged: () => void }) {
  const { t } = useTranslation();
  const setter = useMay("setter"), administrator = useMay("administrator");
  const [name, setName] = useState(machine.name);
  const [token, setToken] = useState<string | null>(null);
  const [removing, setRemoving] = useState(false);
  const { busy, run } = useAction();
  const { value: full } = useLoad((signal) => get<Machine>(`/machines/${machine.id}`, signal), [machine.id]);
  return (
    <div className="data-box">
      <table className="table"><thead><tr><th>{t("machine.limits")}</th><th className="right">min mm</th><th className="right">max mm</th></tr></thead>
        <tbody>{(full?.axes ?? []).map((axis) => typeof axis === "string" ? <tr key={axis}><td>{axis}</td><td /><td /></tr>
          : <tr key={axis.name}><td className="mono">{axis.name}{(axis.diameter || axis.designation === "diameter") ? " ⌀" : ""}</td><td className="num right">{axis.min_mm ?? unknownText}</td><td className="num right">{axis.max_mm ?? unknownText}</td></tr>)}</tbody></table>
      <div className="form">
        {setter && <Field label={t("machine.name")}><span className="row"><input value={name} onChange={(event) => setName(event.target.value)} maxLength={60} />
          <Button busy={busy} disabled={name.trim() === "" || name === machine.name} onClick={() => run(async () => { await patch(`/machines/${machine.id}`, { name: name.trim() }); onChanged(); })}>{t("machine.rename")}</Button></span></Field>}
        {administrator && <div className="row">
          <Button busy={busy} onClick={() => run(async () => setToken((await post<{ enrolment_token?: string; token?: string }>(`/machines/${machine.id}/enrolment`)).enrolment_token ?? ""))}>{t("enrol.new")}</Button>
          <Button kind="danger" onClick={() => setRemoving(true)}>{t("machine.remove")}</Button></div>}
      </div>
      {token !== null && <TokenDialog name={machine.name} token={token} onClose={() => setToken(null)} />}
      {removing && <Dialog title={`${t("machine.remove")}: ${machine.name}`} onClose={() => setRemoving(false)} actions={<>
        <Button onClick={() => setRemoving(false)}>{t("common.cancel")}</Button>
        <Button kind="danger" busy={busy} onClick={() => run(async () => { await remove(`/machines/${machine.id}`); go(address(["floor"])); })}>{t("common.remove")}</Button></>}>
        <p>{t("machine.remove_explained")}</p></Dialog>}
    </div>
  );
}
