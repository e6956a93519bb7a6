// Machine data: offsets, tool life, parameters and variables of a machine, as it has them; edits are collected, shown, then
// written as one and read back. Without a machine: the tool changes ahead in the whole shop, and what waits for a second person.
import { useEffect, useMemo, useRef, useState } from "react";
import { useTranslation } from "react-i18next";
import { ApiError, get, list, page, patch, post, query } from "../../api/client";
import type { Machine } from "../../api/types";
import { moment } from "../../format/time";
import { errorText, reasonText } from "../../i18n";
import { useLoad, useMachine, useShop } from "../../live/hooks";
import { address, go, swap, useRoute } from "../../shell/router";
import { useMay } from "../../shell/session";
import { Button, CsvLink, Dialog, ErrorNote, Field, Note, Panel, Tabs, toast, useAction } from "../../ui/parts";
import { conflicts, findRows, itemsOf, pasteAt, shown, toolSheet, valueOf, variableSheet, withEdit, workSheet, type Edit } from "./grid";
import { LimitsDialog } from "./Limits";
import { Counts, Orders } from "./Orders";
import { Parameters } from "./Parameters";
import { Preview } from "./Preview";
import { Requests } from "./Requests";
import { ToolLifeTable } from "./ToolLife";
import type { LifeGroup, MachineValues, Parameter, SheetRow, Snapshot, ValueChange, ValueItem, ValueRequest } from "./types";
import { ValueGrid, useSheet } from "./ValueGrid";

const tabs = ["offsets", "work", "tool_life", "parameters", "variables", "history"] as const;
type Tab = (typeof tabs)[number];

export function Data() {
  const route = useRoute();
  const machine = route.parts[1] ? Number(route.parts[1]) : null;
  return machine === null ? <ShopData /> : <MachineData key={machine} id={machine} />;
}

function useNames() {
  const { value } = useLoad((signal) => list<Machine>("/machines", signal), []);
  return { machines: value ?? [], names: new Map((value ?? []).map((one) => [one.id, one.name])) };
}

/// The value, at most every 700 ms: machines that write variables all the time do not make the page ask all the time.
function useSettled<T>(value: T): T {
  const [settled, setSettled] = useState(value);
  const last = useRef(0);
  useEffect(() => {
    const timer = setTimeout(() => { last.current = Date.now(); setSettled(value); }, Math.max(0, last.current + 700 - Date.now()));
    return () => clearTimeout(timer);
  }, [value]);
  return settled;
}

function MachineChoice({ machines, chosen }: { machines: Machine[]; chosen: number | null }) {
  const { t } = useTranslation();
  return (
    <select aria-label={t("alarms.machine")} data-field="machine" value={chosen ?? ""} onChange={(event) => go(event.target.value ? address(["data", event.target.value], { tab: new URLSearchParams(location.hash.split("?")[1]).get("tab") }) : address(["data"]))}>
      <option value="">{t("data.whole_shop")}</option>
      {machines.map((one) => <option key={one.id} value={one.id}>{one.name}</option>)}
    </select>
  );
}

function ShopData() {
  const { t } = useTranslation();
  const { machines, names } = useNames();
  const changed = useSettled(useShop((shop) => shop.valuesSeen));
  const { value: life, error, reload: reloadLife } = useLoad((signal) => get<{ items: LifeGroup[]; short_life: string }>("/tool-life", signal), [changed]);
  const { value: waiting, reload } = useLoad((signal) => list<ValueRequest>("/value-requests?state=waiting", signal), [changed]);
  const setter = useMay("setter");
  const { run } = useAction();
  const [limiting, setLimiting] = useState(false);
  const policy = (short_life: string) => run(async () => { await patch("/tool-life", { short_life }); reloadLife(); });
  return (
    <div className="page" data-page="data">
      <div className="page-bar"><h1>{t("nav.data")}</h1><MachineChoice machines={machines} chosen={null} />{setter && <Button data-action="limits" onClick={() => setLimiting(true)}>{t("data.limits")}</Button>}</div>
      {limiting && <LimitsDialog machine={null} onClose={() => setLimiting(false)} />}
      <Requests requests={waiting ?? []} names={names} onChanged={reload} />
      <ErrorNote error={error} />
      <Panel name="tool-changes" title={t("data.tool_changes")} extra={<><CsvLink path="/tool-life" />{setter && life && (
        <label className="inline-field">{t("data.short_life")} <select data-field="short-life" value={life.short_life} onChange={(event) => policy(event.target.value)}>
          {["refuse", "warn", "off"].map((one) => <option key={one} value={one}>{t(`data.short_${one}`)}</option>)}</select></label>)}</>}>
        <ToolLifeTable groups={life?.items ?? []} shopWide /></Panel>
      <Orders machines={machines} names={names} />
      <Counts names={names} />
      <Panel name="machines" title={t("data.choose_machine")}><div className="machine-links">{machines.map((one) => <a key={one.id} className="button" href={address(["data", one.id])}>{one.name}</a>)}</div></Panel>
    </div>
  );
}

function MachineData({ id }: { id: number }) {
  const { t } = useTranslation();
  const route = useRoute();
  const asked = route.search.get("tab") as Tab | null;
  const tab: Tab = asked && tabs.includes(asked) ? asked : "offsets";
  const { machines, names } = useNames();
  const seen = useMachine(id);
  const changed = useSettled(useShop((shop) => shop.valuesSeen.get(id) ?? 0));
  const { value: data, error, reload } = useLoad((signal) => get<MachineValues>(`/machines/${id}/values`, signal), [id, changed]);
  const { value: waiting, reload: reloadWaiting } = useLoad((signal) => list<ValueRequest>(`/value-requests?state=waiting&machine=${id}`, signal), [id, changed]);
  const { value: parameters } = useLoad(async (signal) => (tab === "parameters" ? list<Parameter>(`/machines/${id}/parameters`, signal) : null), [id, tab, changed]);
  const { value: life } = useLoad(async (signal) => (tab === "tool_life" ? list<LifeGroup>(`/tool-life?machine=${id}`, signal) : null), [id, tab, changed]);
  const [edits, setEdits] = useState<ReadonlyMap<string, Edit>>(new Map());
  const [origin, setOrigin] = useState("person");
  const [search, setSearch] = useState("");
  const [onlySet, setOnlySet] = useState(false);
  const [preview, setPreview] = useState<{ title: string; rows: (ValueItem & Partial<SheetRow>)[]; without?: number; origin: string } | null>(null);
  const [choosing, setChoosing] = useState(false);
  const [limiting, setLimiting] = useState(false);
  const may = useMay("setter");
  const file = useRef<HTMLInputElement>(null);
  const { busy, run } = useAction();

  const sheet = useSheet(() => (!data ? { corner: "number", columns: [], rows: [] } : tab === "work" ? workSheet(data.page) : tab === "variables" ? variableSheet(data.page) : toolSheet(data.page)), [data?.page.numbers, data?.page.axes.join(), data?.page.wear, tab, data === undefined]);
  const values = data?.values ?? {};
  const rows = useMemo(() => findRows(sheet.rows, onlySet && search === "" ? "*" : search, values), [sheet, search, onlySet, values]);
  const kind = tab === "history" ? "" : tab;

  useEffect(() => {   // typed but not written: do not lose it by a slip
    if (edits.size === 0) return undefined;
    const ask = (event: BeforeUnloadEvent) => { event.preventDefault(); };
    addEventListener("beforeunload", ask);
    return () => removeEventListener("beforeunload", ask);
  }, [edits]);

  const edit = (what: string, after: number | null) => setEdits((now) => withEdit(now, values, what, after));
  const read = (text: string, title: string) => run(async () => {
    const found = await post<{ items: SheetRow[] }>(`/machines/${id}/values/sheet`, { text });
    setPreview({ title, rows: found.items, origin: "import" });
  });
  const take = (items: ValueItem[], from: string) => {
    setEdits((now) => { const next = new Map(now); for (const one of items) next.set(one.what, { before: one.before, after: one.after }); return next; });
    setOrigin(from);
    setPreview(null);
  };
  const snapshot = () => run(async () => {
    await post(`/machines/${id}/snapshots`, { name: t("data.snapshot_name", { at: new Date().toLocaleString() }) });
    toast("good", t("data.snapshot_made"));
  });

  return (
    <div className="page data-page" data-page="data">
      <div className="page-bar"><h1>{t("nav.data")}</h1><MachineChoice machines={machines} chosen={id} />
        <Tabs label={t("nav.data")} value={tab} onChange={(value) => { setSearch(""); swap(address(["data", id], { tab: value })); }} options={tabs.map((value) => ({ value, text: t(`data.tab_${value}`) }))} /></div>
      <ErrorNote error={error} />
      {data && !data.reported && <Note kind="warn">{t("data.never_reported")}</Note>}
      {!seen.current && data?.reported && <Note kind="warn">{t("data.not_current", { at: moment(data.reported) })}</Note>}
      {tab === "parameters" && data && !data.parameter_write && <Note>{t("data.parameter_write_off")}</Note>}
      <Requests requests={waiting ?? []} names={names} onChanged={() => { reloadWaiting(); reload(); }} />
      {tab === "history" ? <History id={id} changed={changed} /> : (
        <Panel className="flush" name="values">
          <div className="data-bar">
            {tab !== "tool_life" && <input type="search" data-field="search" placeholder={t(tab === "parameters" ? "data.search_parameters" : "data.search")} aria-label={t("data.search")} value={search} onChange={(event) => setSearch(event.target.value)} />}
            {tab !== "tool_life" && <label className="check"><input type="checkbox" checked={onlySet} onChange={(event) => setOnlySet(event.target.checked)} />{t("data.only_set")}</label>}
            <span className="spring" />
            <a className="button small" href={`/api/v1/machines/${id}/values/sheet${query({ kind })}`} download data-action="export">{t("data.export")}</a>
            {may && <><Button small busy={busy} data-action="import" onClick={() => file.current?.click()}>{t("data.import")}</Button>
              <Button small busy={busy} data-action="copy" onClick={() => setChoosing(true)}>{t("data.copy_restore")}</Button>
              <Button small busy={busy} data-action="snapshot" onClick={snapshot}>{t("data.snapshot")}</Button>
              <Button small data-action="limits" onClick={() => setLimiting(true)}>{t("data.limits")}</Button>
              <input ref={file} type="file" accept=".csv,.tsv,.txt,text/csv" hidden onChange={(event) => {
                const chosen = event.target.files?.[0];
                event.target.value = "";
                if (chosen) void chosen.text().then((text) => read(text, chosen.name));
              }} /></>}
          </div>
          {data && (tab === "offsets" || tab === "work" || tab === "variables") && (
            <ValueGrid sheet={sheet} rows={rows} values={values} edits={edits} locked={!may} onEdit={edit}
              onPaste={(text, row, column) => read(text.includes("\t") || !/^[^\d+\-.−]/.test(text) ? pasteAt(text, sheet, rows, row, column) : text, t("data.paste"))} />)}
          {tab === "parameters" && <Parameters parameters={parameters ?? []} edits={edits} text={search} onlySet={onlySet} locked={!may} onEdit={edit} />}
          {tab === "tool_life" && <ToolLifeTable groups={life ?? []} may={may} onEdit={(what, before, after) => setEdits((now) => new Map(now).set(what, { before, after }))} />}
          {(tab === "offsets" || tab === "work") && may && <p className="hint">{t("data.keys")}</p>}
        </Panel>)}
      <ChangeBar id={id} name={names.get(id) ?? String(id)} edits={edits} values={values} origin={origin} onClear={() => { setEdits(new Map()); setOrigin("person"); }}
        onForget={(what) => setEdits((now) => { const next = new Map(now); next.delete(what); return next; })} onWritten={() => { reload(); reloadWaiting(); }} />
      {preview && <Preview title={preview.title} rows={preview.rows} {...(preview.without === undefined ? {} : { without: preview.without })} onClose={() => setPreview(null)} onTake={(items) => take(items, preview.origin)} />}
      {limiting && <LimitsDialog machine={id} onClose={() => setLimiting(false)} />}
      {choosing && <CopyDialog id={id} kind={kind} machines={machines} onClose={() => setChoosing(false)} onFound={(found) => { setChoosing(false); setPreview(found); }} />}
    </div>
  );
}

function ChangeBar({ id, name, edits, values, origin, onClear, onForget, onWritten }: {
  id: number; name: string; edits: ReadonlyMap<string, Edit>; values: MachineValues["values"]; origin: string; onClear: () => void; onForget: (what: string) => void; onWritten: () => void;
}) {
  const { t } = useTranslation();
  const [why, setWhy] = useState("");
  const [problem, setProblem] = useState<unknown>(null);
  const { busy, run } = useAction();
  if (edits.size === 0) return null;
  const clashes = [...edits].filter(([what, one]) => conflicts(one, values, what)).map(([what]) => what);
  const write = () => run(async () => {
    setProblem(null);
    try {
      const made = await post<ValueRequest>(`/machines/${id}/values`, { values: itemsOf(edits), origin, why });
      toast(made.state === "unknown" ? "error" : "good", made.state === "waiting" ? t("data.state_waiting_for", { what: made.needs_second ?? "" }) : t(`data.state_${made.state}`));
      onClear();
      setWhy("");
    } catch (failed) {
      // Nothing was written: what was typed stays, beside the reason.
      setProblem(failed);
    }
    onWritten();
  });
  return (
    <div className="change-bar" data-changes={edits.size} role="region" aria-label={t("data.changes", { count: edits.size })}>
      <div className="change-list">{[...edits].slice(0, 30).map(([what, one]) => (
        <span key={what} className={`chip${clashes.includes(what) ? " bad" : ""}`} data-change={what}><b className="mono">{what}</b> {shown(one.before) || "–"} → {shown(one.after) || "–"}
          {clashes.includes(what) && <em> {t("data.is_now", { value: shown(valueOf(values, what)) || "–" })}</em>}
          <button type="button" aria-label={t("data.take_back")} onClick={() => onForget(what)}>×</button></span>))}
        {edits.size > 30 && <span className="chip">{t("data.and_more", { count: edits.size - 30 })}</span>}</div>
      {problem !== null && <Note kind="error">{problem instanceof ApiError && problem.reason ? `${reasonText(problem.reason)} (${problem.where ?? ""})` : errorText(problem)}</Note>}
      {clashes.length > 0 && <Note kind="warn">{t("data.clash", { count: clashes.length })}</Note>}
      <div className="change-actions">
        <Field label={t("data.why")}><input value={why} maxLength={300} onChange={(event) => setWhy(event.target.value)} /></Field>
        <Button data-action="discard" onClick={onClear}>{t("data.discard")}</Button>
        <Button kind="primary" busy={busy} disabled={clashes.length > 0} data-action="write" onClick={write}>{t("data.write", { count: edits.size, name })}</Button></div>
    </div>
  );
}

function CopyDialog({ id, kind, machines, onClose, onFound }: {
  id: number; kind: string; machines: Machine[]; onClose: () => void; onFound: (found: { title: string; rows: ValueItem[]; without: number; origin: string }) => void;
}) {
  const { t } = useTranslation();
  const { value: snapshots } = useLoad((signal) => list<Snapshot>(`/machines/${id}/snapshots`, signal), [id]);
  const [at, setAt] = useState("");
  const { busy, run } = useAction();
  const look = (from: Record<string, string | number>, title: string, origin: string) => run(async () => {
    const found = await get<{ items: ValueItem[]; without_place: number }>(`/machines/${id}/values/difference${query({ kind, ...from })}`);
    onFound({ title, rows: found.items, without: found.without_place, origin });
  });
  return (
    <Dialog title={t("data.copy_restore")} name="copy" onClose={onClose} actions={<Button onClick={onClose}>{t("common.cancel")}</Button>}>
      <p>{t("data.copy_explained")}</p>
      <h3>{t("data.from_machine")}</h3>
      <div className="machine-links">{machines.filter((one) => one.id !== id).map((one) => <Button key={one.id} busy={busy} data-from={one.id} onClick={() => look({ machine: one.id }, t("data.as_machine", { name: one.name }), "copy")}>{one.name}</Button>)}</div>
      <h3>{t("data.from_moment")}</h3>
      <form className="moment" onSubmit={(event) => { event.preventDefault(); const then = new Date(at); look({ at: then.toISOString() }, t("data.as_at", { at: then.toLocaleString() }), "restore"); }}>
        <input type="datetime-local" step={1} value={at} required aria-label={t("data.from_moment")} onChange={(event) => setAt(event.target.value)} /><Button type="submit" busy={busy}>{t("data.look")}</Button></form>
      <h3>{t("data.from_snapshot")}</h3>
      {(snapshots ?? []).slice(0, 20).map((one) => <div key={one.id} className="snapshot-row"><span>{one.name} · {one.by} · {moment(one.at)}</span><Button small busy={busy} onClick={() => look({ snapshot: one.id }, one.name, "restore")}>{t("data.look")}</Button></div>)}
      {snapshots?.length === 0 && <p className="dim">{t("data.no_snapshots")}</p>}
    </Dialog>
  );
}

function History({ id, changed }: { id: number; changed: number }) {
  const { t } = useTranslation();
  const [what, setWhat] = useState("");
  const [more, setMore] = useState<{ items: ValueChange[]; next: string | null } | null>(null);
  const wanted = what.trim();
  const path = (cursor?: string) => `/machines/${id}/value-changes${query({ what: wanted, limit: 200, cursor })}`;
  const { value, error } = useLoad((signal) => page<ValueChange>(path(), signal), [id, changed, wanted]);
  useEffect(() => setMore(null), [value]);
  const items = [...(value?.items ?? []), ...(more?.items ?? [])];
  const next = more ? more.next : value?.next ?? null;
  return (
    <Panel className="flush" name="history">
      <div className="data-bar"><input type="search" data-field="search" placeholder={t("data.search_history")} aria-label={t("data.search_history")} value={what} onChange={(event) => setWhat(event.target.value)} /><CsvLink path={`/machines/${id}/value-changes${query({ what: wanted })}`} /></div>
      <ErrorNote error={error} />
      <div className="table-box"><table className="table"><thead><tr><th>{t("data.when")}</th><th>{t("data.value")}</th><th className="right">{t("data.before")}</th><th className="right">{t("data.after")}</th><th>{t("data.by_what")}</th><th>{t("data.who")}</th></tr></thead>
        <tbody>{items.map((one) => (
          <tr key={one.id} data-change-row={one.what}><td className="num">{moment(one.at)}</td><td className="mono">{one.what}</td><td className="num right">{shown(one.before) || "–"}</td><td className="num right">{shown(one.after) || "–"}</td>
            <td><span className={`chip${one.origin === "found" ? " warn" : ""}`}>{t(`origin.${one.origin}`, { defaultValue: one.origin })}</span></td><td>{one.by ?? ""}</td></tr>))}</tbody></table></div>
      {value?.items.length === 0 && <div className="empty small">{t("data.no_changes")}</div>}
      {next && <div className="empty small"><Button onClick={() => { void page<ValueChange>(path(next)).then((found) => setMore({ items: [...(more?.items ?? []), ...found.items], next: found.next })); }}>{t("common.more", { defaultValue: "…" })}</Button></div>}
    </Panel>
  );
}
