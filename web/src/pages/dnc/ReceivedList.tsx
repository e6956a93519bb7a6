// What controls have punched. A program goes into the library only when somebody accepts it, with its difference in view.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { get, list, post } from "../../api/client";
import type { Diff, DiffClass } from "../../api/types";
import { moment } from "../../format/time";
import { Code } from "../../gcode/Code";
import { reasonText } from "../../i18n";
import { useLoad } from "../../live/hooks";
import { useMay } from "../../shell/session";
import { Button, Dialog, ErrorNote, Field, Note, Panel, toast, useAction } from "../../ui/parts";
import { classTone } from "../programs/Difference";
import type { Port, PunchedOutcome, Received } from "./types";

export function ReceivedList({ ports, onChanged }: { ports: Port[]; onChanged: () => void }) {
  const { t } = useTranslation();
  const { value, error, reload } = useLoad((signal) => list<Received>("/received?limit=200", signal), []);
  const [shown, setShown] = useState<Received | null>(null);
  const name = (id: number) => ports.find((one) => one.id === id)?.name ?? String(id);
  return (
    <Panel className="flush" name="received">
      <ErrorNote error={error} />
      {value?.length === 0 && <div className="empty small">{t("dnc.received_none")}</div>}
      <table className="table"><tbody>{value?.map((row) => (
        <tr key={row.id} data-received={row.id} data-state={row.state}>
          <td className="dim">{moment(row.at)}</td><td>{name(row.port)}</td><td>{t(`dnc.what_${row.kind}`)}</td><td>{row.name !== row.kind && <b>{row.name}</b>} <span className="dim">{row.comment}</span></td>
          <td>{row.classes.map((one) => <span key={one} className={`chip ${classTone[one as DiffClass] ?? ""}`}>{t(`class.${one}`)}</span>)}</td>
          <td><span className={`chip ${row.state === "waiting" ? "warn" : row.state === "rejected" ? "" : "good"}`}>{t(`dnc.received_${row.state}`)}</span></td>
          <td className="row-actions"><Button small data-action="look" onClick={() => setShown(row)}>{t("dnc.look")}</Button></td></tr>))}</tbody></table>
      {shown && <Decide row={shown} onClose={() => { setShown(null); reload(); onChanged(); }} />}
    </Panel>
  );
}

function Decide({ row, onClose }: { row: Received; onClose: () => void }) {
  const { t } = useTranslation();
  const data = row.kind !== "program";
  const programmer = useMay("programmer"), setter = useMay("setter");
  const open = row.state === "waiting" && programmer, may = open && (!data || setter);
  const { busy, run } = useAction();
  const [why, setWhy] = useState("");
  const [write, setWrite] = useState(false);
  const compared = row.program !== null && row.against_revision !== null;
  const { value: diff } = useLoad<Diff | null>(async (signal) => (compared ? get<Diff>(`/received/${row.id}/diff`, signal) : null), [row.id]);
  const { value: text } = useLoad<{ text: string } | null>(async (signal) => (compared ? null : get<{ text: string }>(`/received/${row.id}/text`, signal)), [row.id]);
  const reject = () => run(async () => { await post(`/received/${row.id}/reject`, { why }); onClose(); });
  const accept = () => run(async () => {
    const { values } = await post<{ values?: PunchedOutcome }>(`/received/${row.id}/accept`, { why, ...(write ? { write } : {}) });
    if (values) toast(values.request_reason ? "error" : "good", [t("dnc.data_outcome", { ...values }),
      values.request_state && t(`data.state_${values.request_state}`), values.request_reason && reasonText(values.request_reason)].filter(Boolean).join(" · "));
    onClose();
  });
  return (
    <Dialog title={[t(`dnc.what_${row.kind}`), row.name !== row.kind && row.name].filter(Boolean).join(" ")} name="received" wide onClose={onClose} actions={open ? <>
      <Button busy={busy} data-action="reject" onClick={reject}>{t("dnc.reject")}</Button>
      {may && <Button kind="primary" busy={busy} data-action="accept" onClick={accept}>{t(data ? "dnc.accept_data" : "dnc.accept")}</Button>}</> : <Button onClick={onClose}>{t("common.close")}</Button>}>
      {!row.closed && <Note kind="warn">{t("dnc.received_open")}</Note>}
      {compared ? <Note>{t("dnc.received_against", { number: row.against_revision })}</Note> : row.kind === "program" && <Note>{t("dnc.received_new", { folder: row.folder })}</Note>}
      {diff && <div className="diff mono received-text"><table><tbody>{diff.rows.slice(0, 2000).map((one, i) => one.kind === "skipped"
        ? <tr key={i} className="skipped"><td colSpan={5}>{t("programs.diff_skipped", { count: one.skipped ?? 0 })}</td></tr>
        : <tr key={i} className={one.kind}><td className="row-number">{one.left_line}</td><td className="left">{one.left !== null && <Code text={one.left} />}</td>
          <td className="row-number">{one.right_line}</td><td className="right-side">{one.right !== null && <Code text={one.right} />}</td>
          <td className="class">{one.class && <span className={`chip ${classTone[one.class]}`}>{t(`class.${one.class}`)}</span>}</td></tr>)}</tbody></table></div>}
      {text && <pre className="mono received-text">{text.text}</pre>}
      {may && data && row.machine !== null && <label className="check"><input type="checkbox" checked={write} data-field="write" onChange={(event) => setWrite(event.target.checked)} /> {t("dnc.data_write")}</label>}
      {open && <Field label={t("dnc.why")}><input value={why} data-field="why" onChange={(event) => setWhy(event.target.value)} /></Field>}
    </Dialog>
  );
}
