import { lazy, Suspense, useState } from "react";
import { useTranslation } from "react-i18next";
import { ApiError, contentAddress, get, list, patch, post, remove } from "../../api/client";
import type { Program, Revision } from "../../api/types";
import { Listing } from "../../gcode/Listing";
import { bytes, grouped } from "../../format/number";
import { moment } from "../../format/time";
import { useLoad, useShop } from "../../live/hooks";
import { address, go, swap, useRoute } from "../../shell/router";
import { useMay } from "../../shell/session";
import { Icon } from "../../ui/icons";
import { Button, Dialog, ErrorNote, Field, Note, Panel, Tabs, toast, useAction } from "../../ui/parts";
import { CheckTab } from "./Check";
import { DiffTab } from "./Difference";
import { SendTab } from "./Send";

const Editor = lazy(() => import("./Editor").then((m) => ({ default: m.Editor })));
const editableBytes = 1 << 20;
type Tab = "text" | "revisions" | "diff" | "check" | "send";
const tabs: Tab[] = ["text", "check", "diff", "revisions", "send"];

export function ProgramPage({ id }: { id: number }) {
  const { t } = useTranslation();
  const route = useRoute();
  const changed = useShop((shop) => shop.programsSeen);
  const { value: program, error, reload } = useLoad((signal) => get<Program>(`/programs/${id}`, signal), [id, changed]);
  const { value: revisions, reload: reloadRevisions } = useLoad(async (signal) => (await list<Revision>(`/programs/${id}/revisions`, signal)).sort((a, b) => b.number - a.number), [id, changed]);
  const [asking, setAsking] = useState<"release" | "withdraw" | "move" | "remove" | "edit" | null>(null);
  const programmer = useMay("programmer"), setter = useMay("setter");
  if (error instanceof ApiError && error.status === 404) return <div className="page"><ErrorNote error={error} /></div>;
  if (!program || !revisions) return <div className="waiting" role="status">{t("common.loading")}</div>;
  const wanted = Number(route.search.get("rev"));
  const revision = revisions.find((one) => one.number === wanted) ?? revisions[0];
  if (!revision) return <div className="page"><div className="empty">{t("common.none")}</div></div>;
  const tab = (route.search.get("tab") as Tab | null) ?? "text";
  const line = Number(route.search.get("line")) || null;
  const show = (change: Record<string, string | number | null>) => swap(address(["programs", id], { rev: route.search.get("rev"), tab, ...change }));
  const released = revisions.find((one) => one.released);
  const changedNow = () => { reload(); reloadRevisions(); setAsking(null); };
  const actions = { onClose: () => setAsking(null), onDone: changedNow, program, revision };
  return (
    <div className="page program" data-page="program" data-revision={revision.number}>
      <div className="program-head">
        <a className="button quiet bare" href={address(["programs"], { folder: program.folder })} aria-label={t("programs.back")}><Icon name="back" /></a>
        <div className="machine-title"><h1>{program.name}</h1><span>{program.folder}</span></div>
        <label className="revision-choice"><span className="visually-hidden">{t("programs.revision")}</span>
          <select name="revision" value={revision.number} onChange={(event) => show({ rev: event.target.value })}>
            {revisions.map((one) => <option key={one.number} value={one.number}>{t("programs.revision_n", { number: one.number })}{one === revisions[0] ? ` · ${t("programs.newest")}` : ""}{one.released ? ` · ${t("programs.released")}` : ""}</option>)}</select></label>
        {revision.released ? <span className="chip good" data-field="released">{t("programs.released")}</span> : <span className="chip" data-field="released">{t("programs.not_released")}</span>}
        <span className="dim num">{t("programs.lines_n", { lines: grouped(revision.lines) })} · {bytes(revision.bytes)} · {revision.encoding}{revision.line_ends ? ` · ${revision.line_ends}` : ""}</span>
        <div className="program-actions">
          {programmer && <Button icon="edit" onClick={() => setAsking("edit")}>{t("programs.edit")}</Button>}
          <a className="button" href={contentAddress(id, revision.number)} download={program.name}><Icon name="download" />{t("programs.download")}</a>
          {setter && !revision.released && <Button kind="primary" icon="check" data-action="release" onClick={() => setAsking("release")}>{t("programs.release")}</Button>}
          {setter && released && <Button kind="quiet" data-action="withdraw" onClick={() => setAsking("withdraw")}>{t("programs.withdraw")}</Button>}
          {programmer && <Button kind="quiet" onClick={() => setAsking("move")}>{t("programs.move")}</Button>}
          {programmer && <Button kind="quiet" icon="trash" aria-label={t("programs.remove")} title={t("programs.remove")} onClick={() => setAsking("remove")} />}
        </div>
      </div>
      <div className="program-why dim">{t("programs.by")} {revision.by} · {moment(revision.at)}{revision.note ? ` · ${revision.note}` : ""}
        {revision.released ? ` · ${t("programs.released_by", { by: revision.released.by, at: moment(revision.released.at), why: revision.released.why })}` : ""}</div>
      <Tabs<Tab> label={program.name} value={tab} onChange={(to) => show({ tab: to, line: null })} options={tabs.map((value) => ({ value, text: t(`programs.tab_${value}`), ...(value === "revisions" ? { count: revisions.length } : {}) }))} />
      {tab === "text" && <TextTab program={program} revision={revision} line={line} onLine={(to) => show({ line: to })} />}
      {tab === "revisions" && <RevisionsTab program={program} revisions={revisions} />}
      {tab === "diff" && <DiffTab program={id} revisions={revisions} chosen={revision.number} />}
      {tab === "check" && <CheckTab program={id} revision={revision} onLine={(to) => show({ tab: "text", line: to })} />}
      {tab === "send" && <SendTab program={program} revision={revision} />}
      {asking === "release" && <Reason {...actions} title={t("programs.release_title", { number: revision.number, name: program.name })} label={t("programs.release_why")} text={t("programs.release_explained")} button={t("programs.release")}
        act={async (why) => { await post(`/programs/${id}/revisions/${revision.number}/release`, { why }); toast("good", t("programs.released_now", { number: revision.number })); }} />}
      {asking === "withdraw" && <Reason {...actions} title={t("programs.withdraw_title", { name: program.name })} label={t("programs.withdraw_why")} button={t("programs.withdraw")}
        act={async (why) => { await remove(`/programs/${id}/release`, { why }); toast("good", t("programs.withdrawn")); }} />}
      {asking === "move" && <Move {...actions} />}
      {asking === "remove" && <Dialog title={t("programs.remove")} onClose={() => setAsking(null)} actions={<><Button onClick={() => setAsking(null)}>{t("common.cancel")}</Button><RemoveButton program={program} /></>}>
        <p>{t("programs.remove_explained", { name: program.name })}</p></Dialog>}
      {asking === "edit" && (revision.bytes > editableBytes
        ? <Dialog title={t("programs.edit")} onClose={() => setAsking(null)} actions={<Button onClick={() => setAsking(null)}>{t("common.close")}</Button>}><Note kind="warn">{t("programs.edit_large")}</Note></Dialog>
        : <Suspense fallback={null}><Editor program={program} revision={revision} onClose={() => setAsking(null)} onSaved={(number) => { changedNow(); show({ rev: number, tab: "text" }); }} /></Suspense>)}
    </div>
  );
}

function TextTab({ program, revision, line, onLine }: { program: Program; revision: Revision; line: number | null; onLine: (line: number) => void }) {
  const { t } = useTranslation();
  const [wanted, setWanted] = useState("");
  return (
    <Panel className="text-tab" name="text">
      <form className="records-bar" onSubmit={(event) => { event.preventDefault(); const to = Math.floor(Number(wanted)); if (to >= 1) onLine(Math.min(to, revision.lines)); }}>
        <label className="row"><span className="dim">{t("programs.go_line")}</span><input className="short num" inputMode="numeric" value={wanted} onChange={(event) => setWanted(event.target.value)} /></label></form>
      <Listing program={program.id} revision={revision.number} total={revision.lines} line={line} follow={line !== null} label={program.name} />
    </Panel>);
}

function RevisionsTab({ program, revisions }: { program: Program; revisions: Revision[] }) {
  const { t } = useTranslation();
  return (
    <Panel className="flush"><table className="table" data-panel="revisions"><thead><tr><th>{t("programs.revision")}</th><th>{t("programs.at")}</th><th>{t("programs.by")}</th><th>{t("programs.note")}</th><th>{t("programs.origin")}</th><th>{t("programs.column_released")}</th><th className="right">{t("programs.column_size")}</th><th /></tr></thead>
      <tbody>{revisions.map((one, i) => {
        const before = revisions[i + 1];
        return (
          <tr key={one.number} data-revision-row={one.number}><td><a href={address(["programs", program.id], { rev: one.number })}><b>{one.number}</b></a></td><td className="num">{moment(one.at)}</td><td>{one.by}</td><td className="grow">{one.note}</td>
            <td>{t(`programs.origin_${one.origin}`, { defaultValue: one.origin })}</td><td>{one.released && <span className="chip good" title={one.released.why}>{one.released.by} · {moment(one.released.at)}</span>}</td><td className="num right">{bytes(one.bytes)}</td>
            <td className="row-actions">{before && <a className="button small quiet" href={address(["programs", program.id], { tab: "diff", rev: one.number, from: before.number })}>{t("programs.compare")}</a>}</td></tr>);
      })}</tbody></table></Panel>);
}

function Reason({ title, label, text, button, act, onClose, onDone }: { title: string; label: string; text?: string; button: string; act: (why: string) => Promise<void>; onClose: () => void; onDone: () => void }) {
  const { t } = useTranslation();
  const [why, setWhy] = useState("");
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  return (
    <Dialog title={title} name="reason" onClose={onClose} actions={<><Button onClick={onClose}>{t("common.cancel")}</Button><Button kind="primary" type="submit" form="reason-form" busy={busy}>{button}</Button></>}>
      <form id="reason-form" className="form" onSubmit={(event) => { event.preventDefault(); setBusy(true); setError(null); act(why.trim()).then(onDone, (problem: unknown) => { setError(problem); setBusy(false); }); }}>
        {text && <p>{text}</p>}
        <Field label={label}><input name="why" value={why} onChange={(event) => setWhy(event.target.value)} required autoFocus maxLength={500} /></Field>
        <ErrorNote error={error} />
      </form>
    </Dialog>);
}

function Move({ program, onClose, onDone }: { program: Program; onClose: () => void; onDone: () => void }) {
  const { t } = useTranslation();
  const [name, setName] = useState(program.name);
  const [folder, setFolder] = useState(program.folder);
  const { busy, run } = useAction();
  return (
    <Dialog title={t("programs.move")} onClose={onClose} actions={<><Button onClick={onClose}>{t("common.cancel")}</Button><Button kind="primary" busy={busy} onClick={() => run(async () => { await patch(`/programs/${program.id}`, { folder, name: name.trim() }); onDone(); })}>{t("common.save")}</Button></>}>
      <Field label={t("programs.column_name")}><input value={name} onChange={(event) => setName(event.target.value)} autoFocus /></Field>
      <Field label={t("programs.folder")}><input value={folder} onChange={(event) => setFolder(event.target.value)} /></Field>
    </Dialog>);
}

function RemoveButton({ program }: { program: Program }) {
  const { t } = useTranslation();
  const { busy, run } = useAction();
  return <Button kind="danger" busy={busy} onClick={() => run(async () => { await remove(`/programs/${program.id}`); toast("good", t("programs.removed", { name: program.name })); go(address(["programs"], { folder: program.folder })); })}>{t("common.remove")}</Button>;
}
