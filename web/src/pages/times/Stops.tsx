// Why the machine stood: a tap on the stop, a tap on the reason.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { list, post, query } from "../../api/client";
import type { DowntimeReason, Stop } from "../../api/types";
import { hours, moment } from "../../format/time";
import { inLanguage } from "../../i18n";
import { useLoad } from "../../live/hooks";
import { useMay } from "../../shell/session";
import { Button, CsvLink, Dialog, ErrorNote, Field, Panel, StateBadge, toast, useAction } from "../../ui/parts";

export function Stops({ machine, span, onChanged }: { machine: number; span: { from: string; to: string }; onChanged: () => void }) {
  const { t } = useTranslation();
  const may = useMay("operator");
  const { value: reasons } = useLoad((signal) => list<DowntimeReason>("/downtime-reasons", signal), []);
  const { value: stops, error, reload } = useLoad((signal) => list<Stop>(`/machines/${machine}/stops${query(span)}`, signal), [machine, span]);
  const [open, setOpen] = useState<Stop | null>(null);
  const [rejecting, setRejecting] = useState(false);
  const { busy, run } = useAction();
  const names = new Map((reasons ?? []).map((reason) => [reason.id, inLanguage(reason.name)]));
  const changed = () => { setOpen(null); setRejecting(false); reload(); onChanged(); };
  const give = (stop: Stop, reason: number | null) => run(async () => {
    await post(`/machines/${machine}/downtime`, { from: stop.from, to: stop.to, reason });
    changed();
  });
  const newest = [...(stops ?? [])].reverse();
  return (
    <Panel name="stops" title={t("times.stops")} extra={<>{may && <Button small onClick={() => setRejecting(true)} data-action="reject">{t("times.enter_rejects")}</Button>}<CsvLink path={`/machines/${machine}/stops${query(span)}`} /></>}>
      <ErrorNote error={error} />
      <table className="table"><tbody>
        {newest.map((stop) => (
          <tr key={stop.from} data-stop={stop.from}>
            <td className="num">{moment(stop.from).slice(5, 16)}</td><td className="num right">{hours((Date.parse(stop.to) - Date.parse(stop.from)) / 1000)}</td>
            <td><StateBadge state={stop.state} />{stop.open && <span className="dim"> {t("times.still")}</span>}</td>
            <td className="grow">{stop.note?.reason ? <><b>{names.get(stop.note.reason) ?? stop.note.reason}</b> <span className="dim">{stop.note.by}</span></> : <span className="dim">{t("times.no_reason")}</span>}</td>
            <td className="row-actions">{may && <Button small kind={stop.note ? "quiet" : "plain"} data-action="why" onClick={() => setOpen(stop)}>{t("times.why")}</Button>}</td>
          </tr>))}
      </tbody></table>
      {stops?.length === 0 && <div className="empty small">{t("times.no_stops")}</div>}
      {open && (
        <Dialog name="why" title={t("times.why_title", { from: moment(open.from).slice(5, 16), length: hours((Date.parse(open.to) - Date.parse(open.from)) / 1000) })}
          onClose={() => setOpen(null)} actions={<>
            {open.note && <Button kind="quiet" busy={busy} onClick={() => give(open, null)}>{t("times.take_back")}</Button>}
            <Button onClick={() => setOpen(null)}>{t("common.cancel")}</Button></>}>
          <div className="reason-grid">
            {(reasons ?? []).map((reason) => (
              <Button key={reason.id} busy={busy} aria-pressed={open.note?.reason === reason.id} data-reason={reason.id} onClick={() => give(open, reason.id)}>
                {inLanguage(reason.name)}{reason.planned && <span className="chip info">{t("times.planned_short")}</span>}</Button>))}
          </div>
        </Dialog>)}
      {rejecting && <Rejects machine={machine} onClose={() => setRejecting(false)} onDone={changed} />}
    </Panel>
  );
}

function Rejects({ machine, onClose, onDone }: { machine: number; onClose: () => void; onDone: () => void }) {
  const { t } = useTranslation();
  const [quantity, setQuantity] = useState("1");
  const [why, setWhy] = useState("");
  const { busy, run } = useAction();
  return (
    <Dialog name="rejects" title={t("times.enter_rejects")} onClose={onClose} actions={<>
      <Button onClick={onClose}>{t("common.cancel")}</Button>
      <Button kind="primary" busy={busy} disabled={!why.trim() || !Number(quantity)} onClick={() => run(async () => {
        await post(`/machines/${machine}/rejects`, { quantity: Math.trunc(Number(quantity)), why: why.trim() });
        toast("good", t("times.rejects_kept"));
        onDone();
      })}>{t("common.save")}</Button></>}>
      <Field label={t("times.quantity")} hint={t("times.quantity_hint")}><input name="quantity" type="number" value={quantity} onChange={(event) => setQuantity(event.target.value)} /></Field>
      <Field label={t("times.reject_why")}><input name="why" value={why} onChange={(event) => setWhy(event.target.value)} /></Field>
    </Dialog>
  );
}
