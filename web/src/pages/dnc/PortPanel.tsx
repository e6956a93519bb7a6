// One port: state, progress, buttons that act at once, and the line monitor when it is open.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { post, remove } from "../../api/client";
import { bytes, percent } from "../../format/number";
import { duration } from "../../format/time";
import { reasonText } from "../../i18n";
import { useMay } from "../../shell/session";
import { Button, Note, Panel, Progress, toast, useAction } from "../../ui/parts";
import { LineMonitor } from "./LineMonitor";
import { PlanLine } from "./Plans";
import { SendDialog } from "./SendDialog";
import { isSending, type Plan, type Port, type PortTransfer } from "./types";

const tone: Record<string, string> = { done: "good", failed: "bad", held: "warn", paused: "warn", waiting: "info" };

export function TransferLine({ transfer }: { transfer: PortTransfer }) {
  const { t } = useTranslation();
  const part = transfer.total ? Math.min(1, transfer.bytes / transfer.total) : null;
  const seconds = transfer.started ? (Date.now() - Date.parse(transfer.started)) / 1000 : 0;
  const left = part && part > 0 && transfer.state === "sending" ? (seconds / part) * (1 - part) : null;
  return (
    <div className="port-transfer" data-port-transfer={transfer.id} data-state={transfer.state}>
      <b>{transfer.name || t(`dnc.kind_${transfer.kind}`)}</b>
      <span className="dim">{t(`dnc.kind_${transfer.kind}`)}{transfer.revision ? ` · ${t("programs.revision_n", { number: transfer.revision })}` : ""}{transfer.from_line > 1 ? ` · ${t("dnc.from_line", { line: transfer.from_line })}` : ""}</span>
      <Progress part={part} label={transfer.name} state={transfer.state} />
      <span className="num">{part === null ? bytes(transfer.bytes) : `${percent(part)} · ${bytes(transfer.bytes)}`}{left !== null ? ` · ${t("programs.eta", { time: duration(left) })}` : ""}</span>
      <span className={`chip ${tone[transfer.state] ?? ""}`}>{t(`dnc.state_${transfer.state}`)}</span>
    </div>
  );
}

/// What the port knows about its own line, and what follows from it.
function Measured({ port }: { port: Port }) {
  const { t } = useTranslation();
  const m = port.measured;
  const starved = m.sending_ms > 0 ? m.starved_ms / m.sending_ms : 0;
  return (
    <span className="port-measured dim" data-measured={m.window}>
      {t("dnc.measured", { window: m.window, after: m.most_after_stop, stops: m.stops })}
      {m.round_trip_us === null ? ` · ${t("dnc.not_looped")}` : ` · ${t("dnc.margin", { count: m.stop_margin })}`}
      {starved > 0.01 && ` · ${t("dnc.starved", { part: percent(starved, 1) })}`}
    </span>
  );
}

export function PortPanel({ port, plans, open, onOpen, onEdit, onChanged }: {
  port: Port; plans: Plan[]; open: boolean; onOpen: (open: boolean) => void; onEdit: () => void; onChanged: () => void;
}) {
  const { t } = useTranslation();
  const operator = useMay("operator"), setter = useMay("setter");
  const { busy, run } = useAction();
  // Stop has its own: it must work while another request is under way.
  const stopping = useAction();
  const [sending, setSending] = useState(false);
  const act = (verb: string) => run(async () => { await post(`/ports/${port.id}/${verb}`); onChanged(); });
  const test = () => run(async () => {
    const report = await post<{ ok: boolean; reason: string | null; sent: number; received: number; round_trip_us: number }>(`/ports/${port.id}/loop-test`);
    if (report.ok) toast("good", t("dnc.test_ok", { count: report.received, us: report.round_trip_us }));
    else toast("error", t("dnc.test_bad", { reason: reasonText(report.reason), sent: report.sent, received: report.received }));
  });
  const transfer = port.transfer;
  return (
    <Panel name={`port-${port.id}`} className={`port state-${port.state}`} title={<><span className={`port-lamp ${port.state}`} aria-hidden="true" />{port.name}</>}
      extra={<><span className="mono dim">{port.address}</span>{port.kind === "line" && <span className="dim">{port.settings.protocol} · {port.settings.line}</span>}
        <span className={`chip ${port.state === "failed" ? "bad" : port.state === "busy" ? "good" : ""}`} data-port-state={port.state}>{t(`dnc.port_${port.state}`)}</span></>}>
      {port.state === "failed" && <Note kind="error">{reasonText(port.reason)}{port.detail ? ` (${port.detail})` : ""}</Note>}
      {port.kind === "line" && port.measured.stop_margin < 0 && <Note kind="warn">{t("dnc.margin_negative")}</Note>}
      {transfer ? <TransferLine transfer={transfer} /> : <p className="dim port-idle">{t(port.kind === "agent" ? "dnc.idle_agent" : port.listens ? "dnc.idle_listening" : "dnc.idle")}</p>}
      {port.queue.map((one) => (
        <div key={one.id} className="port-queue"><span>{t("dnc.queued", { name: one.name })}</span>
          {operator && <Button small kind="quiet" icon="close" aria-label={t("common.remove")} onClick={() => run(async () => { await remove(`/ports/${port.id}/queue/${one.id}`); onChanged(); })} />}</div>))}
      {plans.map((plan) => <PlanLine key={plan.id} plan={plan} onChanged={onChanged} />)}
      <div className="port-actions">
        {operator && <Button icon="send" kind="primary" disabled={transfer !== null && !isSending(transfer)} data-action="send" onClick={() => setSending(true)}>{t("dnc.send")}</Button>}
        {operator && !transfer && port.kind === "line" && <Button icon="download" busy={busy} data-action="receive" onClick={() => act("receive")}>{t("dnc.receive")}</Button>}
        {operator && transfer && port.kind === "line" && isSending(transfer) && transfer.state !== "paused" && <Button kind="hold" busy={busy} data-action="pause" onClick={() => act("pause")}>{t("dnc.pause")}</Button>}
        {operator && transfer && transfer.state === "paused" && <Button kind="go" busy={busy} data-action="resume" onClick={() => act("resume")}>{t("dnc.resume")}</Button>}
        {operator && transfer && <Button kind="danger" data-action="cancel" onClick={() => stopping.run(async () => { await post(`/ports/${port.id}/cancel`); onChanged(); })}>{t("dnc.stop")}</Button>}
        {port.kind === "line" && <Measured port={port} />}
        <span className="end">
          {setter && !transfer && port.kind === "line" && <Button small kind="quiet" busy={busy} data-action="test" onClick={test}>{t("dnc.test")}</Button>}
          {setter && !transfer && <Button small kind="quiet" icon="edit" data-action="edit" onClick={onEdit}>{t("dnc.edit")}</Button>}
          {port.kind === "line" && <Button small kind="quiet" icon={open ? "down" : "right"} aria-expanded={open} data-action="monitor" onClick={() => onOpen(!open)}>{t("dnc.monitor")}</Button>}
        </span>
      </div>
      {open && port.kind === "line" && <LineMonitor port={port} />}
      {sending && <SendDialog port={port} onClose={() => { setSending(false); onChanged(); }} />}
    </Panel>
  );
}
