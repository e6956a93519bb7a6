// The library: folders on the left, programs of the chosen folder on the right; files dropped anywhere are uploaded.
import { useState, type DragEvent } from "react";
import { useTranslation } from "react-i18next";
import { list, post, query, remove } from "../../api/client";
import type { Program } from "../../api/types";
import { bytes, grouped } from "../../format/number";
import { moment } from "../../format/time";
import { useLoad, useShop } from "../../live/hooks";
import { address, go, swap, useRoute } from "../../shell/router";
import { useMay } from "../../shell/session";
import { Icon } from "../../ui/icons";
import { Button, Dialog, ErrorNote, Field, Panel, toast, useAction } from "../../ui/parts";
import { foldersOf, type Folder } from "./folders";
import { ProgramPage } from "./ProgramPage";
import { Transfers } from "./Transfers";
import { UploadDialog } from "./Upload";

export function Programs({ program }: { program: number | null }) {
  return program ? <ProgramPage key={program} id={program} /> : <Library />;
}

function Library() {
  const { t } = useTranslation();
  const route = useRoute();
  const folder = route.search.get("folder") ?? "/";
  const q = route.search.get("q") ?? "";
  const programmer = useMay("programmer");
  const changed = useShop((shop) => shop.programsSeen);
  const [files, setFiles] = useState<File[] | null>(null);
  const [over, setOver] = useState(false);
  const [creating, setCreating] = useState(false);
  const [search, setSearch] = useState(q);
  const { value: paths, reload: reloadFolders } = useLoad((signal) => list<string | { path: string }>("/folders", signal), [changed]);
  const { value: programs, error, reload } = useLoad((signal) => list<Program>(`/programs${query({ folder: q ? null : folder, q, limit: 500 })}`, signal), [folder, q, changed]);
  const folders = foldersOf((paths ?? []).map((one) => (typeof one === "string" ? one : one.path)));
  const show = (change: Record<string, string | null>) => swap(address(["programs"], { folder, q, ...change }));
  const name = folder === "/" ? t("programs.root") : folder;

  const drop = (event: DragEvent) => {
    event.preventDefault();
    setOver(false);
    if (programmer && event.dataTransfer.files.length > 0) setFiles([...event.dataTransfer.files]);
  };
  return (
    <div className={`library${over ? " over" : ""}`} data-page="programs" onDrop={drop}
      onDragOver={(event) => { event.preventDefault(); if (programmer) setOver(true); }}
      onDragLeave={(event) => { if (!event.currentTarget.contains(event.relatedTarget as Node | null)) setOver(false); }}>
      {over && <div className="drop-sign"><Icon name="upload" size={40} />{t("programs.drop", { folder: name })}</div>}
      <aside className="folders">
        <div className="folders-head"><h2>{t("programs.folders")}</h2>{programmer && <Button small kind="quiet" icon="plus" aria-label={t("programs.new_folder")} title={t("programs.new_folder")} onClick={() => setCreating(true)} />}</div>
        <ul role="tree" aria-label={t("programs.folders")}>
          <FolderRow path="/" text={t("programs.root")} depth={0} chosen={folder} onChoose={(path) => show({ folder: path, q: null })} />
          {folders.map((one) => <FolderRow key={one.path} {...one} chosen={folder} onChoose={(path) => show({ folder: path, q: null })} />)}
        </ul>
      </aside>
      <section className="library-main">
        <div className="page-bar">
          <h1>{name}</h1>
          <div className="row">
            <form className="search" role="search" onSubmit={(event) => { event.preventDefault(); show({ q: search.trim() || null }); }}>
              <Icon name="search" /><input type="search" value={search} placeholder={t("programs.search")} aria-label={t("programs.search")}
                onChange={(event) => { setSearch(event.target.value); if (event.target.value === "") show({ q: null }); }} /></form>
            {programmer && folder !== "/" && <RemoveFolder path={folder} onDone={() => { show({ folder: "/" }); reloadFolders(); }} />}
            {programmer && <label className="button primary upload-button"><Icon name="upload" />{t("programs.upload")}
              <input type="file" multiple className="visually-hidden" onChange={(event) => { if (event.target.files?.length) setFiles([...event.target.files]); event.target.value = ""; }} /></label>}
          </div>
        </div>
        <ErrorNote error={error} />
        <Panel className="flush" name="programs">
          <table className="table"><thead><tr><th>{t("programs.column_name")}</th><th>{t("programs.column_newest")}</th><th>{t("programs.column_released")}</th><th className="right">{t("programs.column_lines")}</th><th className="right">{t("programs.column_size")}</th><th>{t("programs.column_changed")}</th><th>{t("programs.column_by")}</th></tr></thead>
            <tbody>{(programs ?? []).map((one) => <ProgramRow key={one.id} program={one} folder={q ? one.folder : folder} />)}</tbody></table>
          {programs?.length === 0 && <div className="empty">{t(q ? "programs.none_found" : "programs.drop_hint")}</div>}
        </Panel>
        <Panel title={t("programs.transfers")} name="transfers"><Transfers limit={8} /></Panel>
      </section>
      {files && <UploadDialog files={files} folder={folder} folders={["/", ...folders.map((one) => one.path)]} onClose={() => { setFiles(null); reload(); reloadFolders(); }} />}
      {creating && <NewFolder parent={folder} onClose={() => setCreating(false)} onDone={(path) => { setCreating(false); reloadFolders(); show({ folder: path, q: null }); }} />}
    </div>
  );
}

function FolderRow({ path, text, depth, chosen, onChoose }: Folder & { chosen: string; onChoose: (path: string) => void }) {
  return <li role="treeitem" aria-selected={chosen === path} aria-level={depth + 1}>
    <button type="button" data-folder={path} aria-current={chosen === path ? "true" : undefined} style={{ paddingLeft: 10 + depth * 16 }} onClick={() => onChoose(path)}><Icon name="folder" />{text}</button></li>;
}

function ProgramRow({ program, folder }: { program: Program; folder: string }) {
  const { t } = useTranslation();
  const { newest, released } = program;
  const open = () => go(address(["programs", program.id]));
  return (
    <tr className="clickable" data-program={program.name} onClick={open}>
      <td><a href={address(["programs", program.id])} onClick={(event) => event.stopPropagation()}><b>{program.name}</b></a>{program.folder !== folder && <small className="dim"> {program.folder}</small>}</td>
      <td className="num">{newest ? newest.number : ""}</td>
      <td>{released ? <span className={`chip ${released.number === newest?.number ? "good" : "warn"}`}>{t("programs.revision_n", { number: released.number })}</span> : <span className="dim">{t("programs.not_released")}</span>}</td>
      <td className="num right">{newest ? grouped(newest.lines) : ""}</td><td className="num right">{bytes(newest?.bytes)}</td>
      <td className="num">{moment(newest?.at)}</td><td>{newest?.by}</td>
    </tr>);
}

function NewFolder({ parent, onClose, onDone }: { parent: string; onClose: () => void; onDone: (path: string) => void }) {
  const { t } = useTranslation();
  const [path, setPath] = useState(parent === "/" ? "/" : `${parent}/`);
  const { busy, run } = useAction();
  return (
    <Dialog title={t("programs.new_folder")} name="new-folder" onClose={onClose} actions={<><Button onClick={onClose}>{t("common.cancel")}</Button>
      <Button kind="primary" type="submit" form="folder-form" busy={busy}>{t("common.create")}</Button></>}>
      <form id="folder-form" onSubmit={(event) => { event.preventDefault(); run(async () => { const clean = `/${path.split("/").filter(Boolean).join("/")}`; await post("/folders", { path: clean }); onDone(clean); }); }}>
        <Field label={t("programs.folder_name")}><input name="path" value={path} onChange={(event) => setPath(event.target.value)} autoFocus spellCheck={false} required /></Field></form>
    </Dialog>);
}

function RemoveFolder({ path, onDone }: { path: string; onDone: () => void }) {
  const { t } = useTranslation();
  const { busy, run } = useAction();
  return <Button icon="trash" kind="quiet" busy={busy} aria-label={t("programs.remove_folder")} title={t("programs.remove_folder")}
    onClick={() => run(async () => { await remove(`/folders${query({ path })}`, { path }); toast("good", t("programs.remove_folder")); onDone(); })} />;
}
