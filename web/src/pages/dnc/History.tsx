// What went over the ports: a certificate each, with what revision, how long, how many characters, and how it ended.
import { useTranslation } from "react-i18next";
import { list } from "../../api/client";
import { bytes } from "../../format/number";
import { duration, moment } from "../../format/time";
import { reasonText } from "../../i18n";
import { useLoad } from "../../live/hooks";
import { Button, ErrorNote, Panel } from "../../ui/parts";
import type { Port, PortTransfer } from "./types";

function save(rows: PortTransfer[], name: (port: number) => string): void {
  const quoted = (value: unknown) => `"${String(value ?? "").replaceAll('"', '""')}"`;
  const text = [["id", "port", "kind", "name", "revision", "from_line", "bytes", "state", "reason", "by", "created", "started", "ended", "sha256"].join(","),
    ...rows.map((row) => [row.id, name(row.port), row.kind, row.name, row.revision, row.from_line, row.bytes, row.state, row.reason, row.by, row.created, row.started, row.ended, row.wire_sha256].map(quoted).join(","))].join("\r\n");
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  link.download = "port-transfers.csv";
  link.click();
  URL.revokeObjectURL(link.href);
}

export function History({ ports }: { ports: Port[] }) {
  const { t } = useTranslation();
  const { value, error } = useLoad((signal) => list<PortTransfer>("/port-transfers?limit=500", signal), []);
  const name = (id: number) => ports.find((one) => one.id === id)?.name ?? String(id);
  const took = (row: PortTransfer) => (row.started && row.ended ? duration((Date.parse(row.ended) - Date.parse(row.started)) / 1000) : "");
  return (
    <Panel className="flush" name="port-history" extra={<Button small icon="download" disabled={!value?.length} onClick={() => save(value ?? [], name)}>{t("dnc.export")}</Button>} title={t("dnc.tab_history")}>
      <ErrorNote error={error} />
      {value?.length === 0 && <div className="empty small">{t("dnc.history_none")}</div>}
      <table className="table"><tbody>{value?.map((row) => (
        <tr key={row.id} data-history={row.id}><td className="dim">{moment(row.created)}</td><td>{name(row.port)}</td><td>{t(`dnc.kind_${row.kind}`)}</td>
          <td><b>{row.name}</b>{row.revision ? ` ${t("programs.revision_n", { number: row.revision })}` : ""}{row.from_line > 1 ? ` · ${t("dnc.from_line", { line: row.from_line })}` : ""}</td>
          <td className="num">{bytes(row.bytes)}</td><td className="num">{took(row)}</td><td>{row.by}</td>
          <td className="mono dim" title={row.wire_sha256 ?? ""}>{row.wire_sha256?.slice(0, 10)}</td>
          <td><span className={`chip ${row.state === "done" ? "good" : row.state === "failed" ? "bad" : ""}`}>{t(`dnc.state_${row.state}`)}</span> {reasonText(row.reason)}</td></tr>))}</tbody></table>
    </Panel>
  );
}
