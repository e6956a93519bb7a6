// Several files at once, each with its own progress and its own result; one that fails does not stop the others.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { query, upload } from "../../api/client";
import type { Uploaded } from "../../api/types";
import { bytes } from "../../format/number";
import { errorText } from "../../i18n";
import { address } from "../../shell/router";
import { Button, Dialog, Field, Progress } from "../../ui/parts";

type Entry = { file: File; name: string; state: "waiting" | "sending" | "done" | "failed"; part: number; result?: Uploaded; error?: unknown };

export function UploadDialog({ files, folder, folders, onClose }: { files: File[]; folder: string; folders: string[]; onClose: () => void }) {
  const { t } = useTranslation();
  const [entries, setEntries] = useState<Entry[]>(() => files.map((file) => ({ file, name: file.name, state: "waiting", part: 0 })));
  const [target, setTarget] = useState(folder);
  const [note, setNote] = useState("");
  const [started, setStarted] = useState(false);
  const set = (index: number, change: Partial<Entry>) => setEntries((all) => all.map((one, i) => (i === index ? { ...one, ...change } : one)));
  const finished = started && entries.every((one) => one.state === "done" || one.state === "failed");

  const start = async () => {
    setStarted(true);
    // One after the other: the order of revisions is the order of the list.
    for (const [index, entry] of entries.entries()) {
      set(index, { state: "sending" });
      try {
        const result = await upload<Uploaded>(`/programs${query({ folder: target, name: entry.name, note: note.trim() })}`, entry.file, (part) => set(index, { part }));
        set(index, { state: "done", part: 1, result });
      } catch (error) {
        set(index, { state: "failed", error });
      }
    }
  };
  return (
    <Dialog title={t("programs.upload_title", { folder: target === "/" ? t("programs.root") : target })} name="upload" wide onClose={onClose} actions={finished
      ? <Button kind="primary" autoFocus onClick={onClose}>{t("common.done")}</Button>
      : <><Button disabled={started} onClick={onClose}>{t("common.cancel")}</Button><Button kind="primary" busy={started} data-action="upload" onClick={() => void start()}>{t("programs.upload_start", { count: entries.length })}</Button></>}>
      {!started && <>
        <Field label={t("programs.folder")}><select value={target} onChange={(event) => setTarget(event.target.value)}>{folders.map((one) => <option key={one} value={one}>{one === "/" ? t("programs.root") : one}</option>)}</select></Field>
        <Field label={t("programs.upload_note")} hint={t("programs.upload_note_hint")}><input name="note" value={note} onChange={(event) => setNote(event.target.value)} autoFocus maxLength={500}
          onKeyDown={(event) => { if (event.key === "Enter") void start(); }} /></Field></>}
      <ul className="upload-list">
        {entries.map((entry, index) => (
          <li key={index} data-upload={entry.file.name} data-state={entry.state}>
            {started ? <b>{entry.result ? <a href={address(["programs", entry.result.program.id])} onClick={onClose}>{entry.name}</a> : entry.name}</b>
              : <input aria-label={t("programs.column_name")} value={entry.name} onChange={(event) => set(index, { name: event.target.value })} spellCheck={false} />}
            <span className="dim num">{bytes(entry.file.size)}</span>
            <Progress part={entry.part} label={entry.name} state={entry.state} />
            <span className={`upload-result ${entry.state}`}>{resultText(entry, t)}</span>
          </li>))}
      </ul>
    </Dialog>
  );
}

function resultText(entry: Entry, t: (key: string, values?: Record<string, unknown>) => string): string {
  if (entry.state === "failed") return errorText(entry.error);
  if (entry.state === "waiting") return t("programs.upload_waiting");
  if (entry.state === "sending") return t("programs.upload_sending");
  const { created = false, duplicate_of: same, program, revision } = entry.result ?? ({} as Uploaded);
  const findings = entry.result?.findings_encoding;
  const warning = findings && findings.nul_bytes > 0 ? ` · NUL × ${findings.nul_bytes}` : "";
  if (!created) return t("programs.upload_same", { number: revision.number }) + warning;
  if (same && same.program === program.id) return t("programs.upload_same", { number: same.revision }) + warning;
  return (revision.number === 1 ? t("programs.upload_new") : t("programs.upload_revision", { number: revision.number })) + warning;
}
