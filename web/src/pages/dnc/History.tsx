// What went over the ports: a certificate each, with what revision, how long, how many characters, and how it ended.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { get, list } from "../../api/client";
import { bytes } from "../../format/number";
import { duration, moment } from "../../format/time";
import { reasonText } from "../../i18n";
import { useLoad } from "../../live/hooks";
import { Button, Dialog, ErrorNote, Note, Panel } from "../../ui/parts";
import type { Port, PortTransfer } from "./types";

function Tail({ row, onClose }: { row: PortTransfer; onClose: () => void }) {
  const { t } = useTranslation();
  const { value, error } = useLoad((signal) => get<{ text: string | null; line: number | null }>(`/port-transfers/${row.id}/tail`, signal), [row.id]);
  return (
    <Dialog title={`${t(`dnc.kind_${row.kind}`)} ${row.name}`} name="certificate" wide onClose={onClose} actions={<Button onClick={onClose}>{t("common.close")}</Button>}>
      <ErrorNote error={error} />
      <dl className="facts">
        <dt>{t("dnc.cert_outcome")}</dt><dd>{t(`dnc.state_${row.state}`)} {reasonText(row.reason)} {row.detail}</dd>
        <dt>{t("dnc.cert_characters")}</dt><dd>{row.bytes}{row.total !== null ? ` / ${row.total}` : ""}</dd>
        <dt>{t("dnc.cert_content")}</dt><dd className="mono">{row.sha256 ?? "–"}</dd>
        <dt>{t("dnc.cert_line")}</dt><dd className="mono">{row.wire_sha256 ?? "–"}</dd>
        <dt>{t("dnc.cert_stops")}</dt><dd>{row.figures.stops ?? 0} · {t("dnc.cert_after", { count: row.figures.most_after_stop ?? 0 })} · {t("dnc.cert_held", { time: duration((row.figures.held_ms ?? 0) / 1000) })}</dd>
      </dl>
      {value && value.text !== null && <><h3>{t("dnc.tail")}</h3>
        <pre className="mono received-text" data-tail={value.line ?? ""}>{value.text}</pre>
        {value.line !== null && <Note>{t("dnc.tail_line", { line: value.line })}</Note>}</>}
    </Dialog>
  );
}

export function History({ ports }: { ports: Port[] }) {
  const { t } = useTranslation();
  const { value, error } = useLoad((signal) => list<PortTransfer>("/port-transfers?limit=500", signal), []);
  const [shown, setShown] = useState<PortTransfer | null>(null);
  const name = (id: number) => ports.find((one) => one.id === id)?.name ?? String(id);
  const took = (row: PortTransfer) => (row.started && row.ended ? duration((Date.parse(row.ended) - Date.parse(row.started)) / 1000) : "");
  return (
    <Panel className="flush" name="port-history" extra={<a className="button small" data-action="export" href="/api/v1/transfer-log" download="transfers.csv">{t("dnc.export")}</a>} title={t("dnc.tab_history")}>
      <ErrorNote error={error} />
      {value?.length === 0 && <div className="empty small">{t("dnc.history_none")}</div>}
      <table className="table"><tbody>{value?.map((row) => (
        <tr key={row.id} data-history={row.id}><td className="dim">{moment(row.created)}</td><td>{name(row.port)}</td><td>{t(`dnc.kind_${row.kind}`)}</td>
          <td><b>{row.name}</b>{row.revision ? ` ${t("programs.revision_n", { number: row.revision })}` : ""}{row.from_line > 1 ? ` · ${t("dnc.from_line", { line: row.from_line })}` : ""}</td>
          <td className="num">{bytes(row.bytes)}</td><td className="num">{took(row)}</td><td>{row.by}</td>
          <td className="mono dim" title={row.wire_sha256 ?? ""}>{row.wire_sha256?.slice(0, 10)}</td>
          <td><span className={`chip ${row.state === "done" ? "good" : row.state === "failed" ? "bad" : ""}`}>{t(`dnc.state_${row.state}`)}</span> {reasonText(row.reason)}</td>
          <td className="row-actions"><Button small data-action="certificate" onClick={() => setShown(row)}>{t("dnc.look")}</Button></td></tr>))}</tbody></table>
      {shown && <Tail row={shown} onClose={() => setShown(null)} />}
    </Panel>
  );
}
