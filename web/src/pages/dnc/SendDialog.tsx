// What to send: a released program, whole or as drip-feed, from its beginning or from a line behind a header that somebody
// has read. Nothing is sent before the last button.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { list, post, query } from "../../api/client";
import type { Program } from "../../api/types";
import { inLanguage } from "../../i18n";
import { useLoad } from "../../live/hooks";
import { Button, Dialog, ErrorNote, Field, Note, toast } from "../../ui/parts";
import type { Port, PortTransfer } from "./types";

interface Restart { header: string; lines: number; error: { message: { en: string; zh: string }; where: string } | null }

export function SendDialog({ port, onClose }: { port: Port; onClose: () => void }) {
  const { t } = useTranslation();
  const [q, setQ] = useState("");
  const { value: programs } = useLoad((signal) => list<Program>(`/programs${query({ q, limit: 200 })}`, signal), [q]);
  const released = (programs ?? []).filter((one) => one.released);
  const [chosen, setChosen] = useState<number | null>(null);
  const program = released.find((one) => one.id === chosen) ?? null;
  const [drip, setDrip] = useState(false);
  const [line, setLine] = useState("1");
  const [restart, setRestart] = useState<Restart | null>(null);
  const [header, setHeader] = useState("");
  const [read, setRead] = useState(false);
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const from = Math.max(1, Math.floor(Number(line)) || 1);
  const again = from > 1;
  const forget = () => { setRestart(null); setHeader(""); setRead(false); setError(null); };
  const work = (action: () => Promise<void>) => { setBusy(true); setError(null); action().catch(setError).finally(() => setBusy(false)); };
  const ask = () => work(async () => {
    const found = await post<Restart>(`/ports/${port.id}/restart`, { program: program?.id, revision: program?.released?.number, line: from });
    setRestart(found);
    setHeader(found.header);
  });
  const send = () => work(async () => {
    const made = await post<PortTransfer>(`/ports/${port.id}/send`, { program: program?.id, revision: program?.released?.number, drip, queue: port.transfer !== null, ...(again ? { from_line: from, header } : {}) });
    toast("good", t(made.state === "queued" ? "dnc.send_accepted" : "dnc.send_accepted", { name: made.name }));
    onClose();
  });
  const ready = program !== null && (!again || (restart !== null && restart.error === null && read));
  return (
    <Dialog title={t("dnc.send_title", { port: port.name })} name="port-send" wide onClose={onClose} actions={<>
      <Button onClick={onClose}>{t("common.cancel")}</Button>
      {again && !restart && <Button kind="primary" busy={busy} disabled={!program} data-action="ask-restart" onClick={ask}>{t("dnc.restart_show")}</Button>}
      {(!again || restart) && <Button kind="primary" icon="send" busy={busy} disabled={!ready} data-action="send-now" onClick={send}>{t(port.transfer ? "dnc.send_queue" : "dnc.send_now")}</Button>}</>}>
      <Field label={t("dnc.send_program")}><input value={q} placeholder={t("dnc.send_search")} onChange={(event) => { setQ(event.target.value); }} /></Field>
      <select size={7} className="program-choice" data-field="program" value={chosen ?? ""} onChange={(event) => { setChosen(Number(event.target.value)); forget(); }}>
        {released.map((one) => <option key={one.id} value={one.id}>{one.folder === "/" ? "" : `${one.folder}/`}{one.name} · {t("programs.revision_n", { number: one.released?.number ?? 0 })}</option>)}
      </select>
      <small className="dim">{t("dnc.send_released_only")}</small>
      <label className="check"><input type="checkbox" checked={drip} data-field="drip" onChange={(event) => setDrip(event.target.checked)} />{t("dnc.send_drip")}</label>
      <Field label={t("dnc.send_from")}><input type="number" min={1} value={line} data-field="line" onChange={(event) => { setLine(event.target.value); forget(); }} /></Field>
      {restart?.error && <Note kind="error">{inLanguage(restart.error.message)} {restart.error.where}</Note>}
      {restart && !restart.error && <>
        <Note kind="warn">{t("dnc.restart_read")}</Note>
        <textarea className="mono restart-header" rows={12} value={header} data-field="header" onChange={(event) => { setHeader(event.target.value); setRead(false); }} />
        <label className="check"><input type="checkbox" checked={read} data-field="read" onChange={(event) => setRead(event.target.checked)} />{t("dnc.restart_confirm")}</label></>}
      <ErrorNote error={error} />
    </Dialog>
  );
}
