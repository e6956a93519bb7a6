// Small changes at the desk. Nothing is overwritten: saving makes a new revision with its reason.
import { defaultKeymap, history, historyKeymap } from "@codemirror/commands";
import { HighlightStyle, StreamLanguage, syntaxHighlighting } from "@codemirror/language";
import { highlightSelectionMatches, searchKeymap } from "@codemirror/search";
import { EditorState } from "@codemirror/state";
import { drawSelection, EditorView, highlightActiveLine, highlightActiveLineGutter, keymap, lineNumbers } from "@codemirror/view";
import { tags } from "@lezer/highlight";
import { useEffect, useRef, useState } from "react";
import { useTranslation } from "react-i18next";
import { query, upload, wholeText } from "../../api/client";
import type { Program, Revision, Uploaded } from "../../api/types";
import { tokens, type TokenKind } from "../../gcode/tokens";
import { Button, Dialog, ErrorNote, Field, toast } from "../../ui/parts";

const names: Partial<Record<TokenKind, string>> = { comment: "comment", program: "heading", sequence: "meta", g: "keyword", m: "atom", fst: "number", axis: "variableName", macro: "macroName", number: "literal" };
const gcode = StreamLanguage.define({
  token(stream) {
    const [first] = tokens(stream.string.slice(stream.pos));
    stream.pos += Math.max(1, first?.text.length ?? 1);
    return (first && names[first.kind]) ?? null;
  },
});
const colours = HighlightStyle.define([
  { tag: tags.comment, class: "tk-comment" }, { tag: tags.heading, class: "tk-program" }, { tag: tags.meta, class: "tk-sequence" }, { tag: tags.keyword, class: "tk-g" },
  { tag: tags.atom, class: "tk-m" }, { tag: tags.number, class: "tk-fst" }, { tag: tags.macroName, class: "tk-macro" }, { tag: tags.literal, class: "tk-number" },
]);

export function Editor({ program, revision, onClose, onSaved }: { program: Program; revision: Revision; onClose: () => void; onSaved: (number: number) => void }) {
  const { t } = useTranslation();
  const host = useRef<HTMLDivElement>(null);
  const view = useRef<EditorView | null>(null);
  const ends = useRef("\n");
  const [note, setNote] = useState("");
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(true);
  useEffect(() => {
    let closed = false;
    wholeText(program.id, revision.number).then((text) => {
      if (closed || !host.current) return;
      // A controller may care how lines end: they are written as they were read.
      ends.current = text.includes("\r\n") ? "\r\n" : text.includes("\r") && !text.includes("\n") ? "\r" : "\n";
      view.current = new EditorView({
        parent: host.current,
        state: EditorState.create({ doc: text, extensions: [lineNumbers(), history(), drawSelection(), highlightActiveLine(), highlightActiveLineGutter(), highlightSelectionMatches(), gcode, syntaxHighlighting(colours), keymap.of([...defaultKeymap, ...historyKeymap, ...searchKeymap]), EditorView.contentAttributes.of({ "aria-label": program.name })] }),
      });
      view.current.focus();
      setBusy(false);
    }, setError);
    return () => { closed = true; view.current?.destroy(); };
  }, [program.id, program.name, revision.number]);
  const save = () => {
    if (!view.current) return;
    setBusy(true);
    const text = view.current.state.doc.toString().replaceAll("\n", ends.current);
    upload<Uploaded>(`/programs${query({ folder: program.folder, name: program.name, note: note.trim() })}`, new Blob([text]), () => {})
      .then(({ revision: made }) => { toast("good", t("programs.saved", { number: made.number })); onSaved(made.number); }, (problem: unknown) => { setError(problem); setBusy(false); });
  };
  return (
    <Dialog title={t("programs.edit_title", { name: program.name })} name="editor" wide onClose={onClose} actions={<><span className="dim end-left">{t("programs.edit_hint")}</span><Button onClick={onClose}>{t("common.cancel")}</Button><Button kind="primary" busy={busy} onClick={save}>{t("programs.edit_save")}</Button></>}>
      <div className="editor mono" ref={host} />
      <Field label={t("programs.upload_note")}><input name="note" value={note} onChange={(event) => setNote(event.target.value)} maxLength={500} /></Field>
      <ErrorNote error={error} />
    </Dialog>);
}
