// What to send: a released program, whole or as drip-feed, from its beginning or from a line, block, sequence number or tool behind
// a header that somebody has read; now, when the control asks, or at a time. Nothing is sent before the last button.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { list, post, query } from "../../api/client";
import type { Program } from "../../api/types";
import { inLanguage } from "../../i18n";
import { useLoad } from "../../live/hooks";
import { Button, Dialog, ErrorNote, Field, Note, toast } from "../../ui/parts";
import type { Port, PortTransfer } from "./types";

type By = "line" | "block" | "sequence" | "tool";
type When = "now" | "armed" | "time";
interface Restart { header: string; lines: number; line: number; text: string; occurrences: number; error: { message: { en: string; zh: string }; where: string } | null }

export function SendDialog({ port, onClose }: { port: Port; onClose: () => void }) {
  const { t } = useTranslation();
  const [q, setQ] = useState("");
  const { value: programs } = useLoad((signal) => list<Program>(`/programs${query({ q, limit: 200 })}`, signal), [q]);
  const released = (programs ?? []).filter((one) => one.released);
  const [chosen, setChosen] = useState<number | null>(null);
  const program = released.find((one) => one.id === chosen) ?? null;
  const [drip, setDrip] = useState(false);
  const [by, setBy] = useState<By>("line");
  const [line, setLine] = useState("1");
  const [occurrence, setOccurrence] = useState("1");
  const [when, setWhen] = useState<When>("now");
  const [time, setTime] = useState("");
  const [restart, setRestart] = useState<Restart | null>(null);
  const [header, setHeader] = useState("");
  const [read, setRead] = useState(false);
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const from = Math.max(0, Math.floor(Number(line)) || 0);
  // The first line is the beginning; a sequence number or a tool is always a place of its own.
  const again = port.kind === "line" && (by === "line" ? from > 1 : from > 0);
  const forget = () => { setRestart(null); setHeader(""); setRead(false); setError(null); };
  const work = (action: () => Promise<void>) => { setBusy(true); setError(null); action().catch(setError).finally(() => setBusy(false)); };
  const ask = () => work(async () => {
    const found = await post<Restart>(`/ports/${port.id}/restart`, { program: program?.id, revision: program?.released?.number, [by]: from, ...(by === "line" ? {} : { occurrence: Math.max(1, Math.floor(Number(occurrence)) || 1) }) });
    setRestart(found);
    setHeader(found.header);
  });
  const send = () => work(async () => {
    const wish = { program: program?.id, revision: program?.released?.number, drip, ...(again ? { from_line: restart?.line, header } : {}) };
    if (when === "time") {
      await post(`/ports/${port.id}/plans`, { ...wish, at: new Date(time).toISOString() });
      toast("good", t("dnc.plan_made", { name: program?.name }));
    } else {
      const made = await post<PortTransfer>(`/ports/${port.id}/send`, { ...wish, ...(port.kind === "line" ? { queue: port.transfer !== null, armed: when === "armed" } : {}) });
      toast("good", t("dnc.send_accepted", { name: made.name }));
    }
    onClose();
  });
  const ready = program !== null && (when !== "time" || time !== "") && (!again || (restart !== null && restart.error === null && read));
  return (
    <Dialog title={t("dnc.send_title", { port: port.name })} name="port-send" wide onClose={onClose} actions={<>
      <Button onClick={onClose}>{t("common.cancel")}</Button>
      {again && !restart && <Button kind="primary" busy={busy} disabled={!program} data-action="ask-restart" onClick={ask}>{t("dnc.restart_show")}</Button>}
      {(!again || restart) && <Button kind="primary" icon="send" busy={busy} disabled={!ready} data-action="send-now" onClick={send}>{t(when === "time" ? "dnc.send_plan" : port.transfer && port.kind === "line" ? "dnc.send_queue" : "dnc.send_now")}</Button>}</>}>
      <Field label={t("dnc.send_program")}><input value={q} placeholder={t("dnc.send_search")} onChange={(event) => { setQ(event.target.value); }} /></Field>
      <select size={5} className="program-choice" data-field="program" value={chosen ?? ""} onChange={(event) => { setChosen(Number(event.target.value)); forget(); }}>
        {released.map((one) => <option key={one.id} value={one.id}>{one.folder === "/" ? "" : `${one.folder}/`}{one.name} · {t("programs.revision_n", { number: one.released?.number ?? 0 })}</option>)}
      </select>
      <small className="dim">{t("dnc.send_released_only")}</small>
      <label className="check"><input type="checkbox" checked={drip} data-field="drip" onChange={(event) => setDrip(event.target.checked)} />{t("dnc.send_drip")}</label>
      <div className="form-grid">
        {port.kind === "line" && <Field label={t("dnc.send_from")}><span className="send-from"><select value={by} data-field="by" aria-label={t("dnc.send_from")} onChange={(event) => { setBy(event.target.value as By); setLine(event.target.value === "line" ? "1" : ""); forget(); }}>
          {(["line", "block", "sequence", "tool"] as const).map((one) => <option key={one} value={one}>{t(`dnc.by_${one}`)}</option>)}</select>
          <input type="number" min={0} value={line} data-field="line" aria-label={t(`dnc.by_${by}`)} onChange={(event) => { setLine(event.target.value); forget(); }} /></span></Field>}
        {again && by !== "line" && by !== "block" && <Field label={t("dnc.send_occurrence")}><input type="number" min={1} value={occurrence} data-field="occurrence" onChange={(event) => { setOccurrence(event.target.value); forget(); }} /></Field>}
        <Field label={t("dnc.send_when")}><select value={when} data-field="when" onChange={(event) => setWhen(event.target.value as When)}>
          <option value="now">{t(port.transfer && port.kind === "line" ? "dnc.when_queue" : "dnc.when_now")}</option>{port.kind === "line" && <option value="armed">{t("dnc.when_armed")}</option>}<option value="time">{t("dnc.when_time")}</option></select></Field>
        {when === "time" && <Field label={t("dnc.when_time")} hint={t("dnc.when_time_hint")}><input type="datetime-local" value={time} data-field="time" onChange={(event) => setTime(event.target.value)} /></Field>}
      </div>
      {restart?.error && <Note kind="error">{inLanguage(restart.error.message)} {restart.error.where}</Note>}
      {restart && <Note>{t("dnc.restart_place", { line: restart.line, text: restart.text })}{restart.occurrences > 1 ? ` ${t("dnc.restart_occurrences", { count: restart.occurrences })}` : ""}</Note>}
      {restart && !restart.error && <>
        <Note kind="warn">{t("dnc.restart_read")}</Note>
        <textarea className="mono restart-header" rows={12} value={header} data-field="header" onChange={(event) => { setHeader(event.target.value); setRead(false); }} />
        <label className="check"><input type="checkbox" checked={read} data-field="read" onChange={(event) => setRead(event.target.checked)} />{t("dnc.restart_confirm")}</label></>}
      <ErrorNote error={error} />
    </Dialog>
  );
}
