// Programs on their way to machines: newest first, live.
import { useTranslation } from "react-i18next";
import { list, remove } from "../../api/client";
import type { Machine, Program, Transfer } from "../../api/types";
import { bytes, percent } from "../../format/number";
import { duration, moment } from "../../format/time";
import { reasonText } from "../../i18n";
import { useLoad, useShop, useTransfers } from "../../live/hooks";
import { useMay } from "../../shell/session";
import { Button, Progress, useAction } from "../../ui/parts";

export const isOver = (transfer: Transfer) => ["done", "failed", "cancelled"].includes(transfer.state);

export function TransferRow({ transfer, machine, program }: { transfer: Transfer; machine: string; program?: string }) {
  const { t } = useTranslation();
  const operator = useMay("operator");
  const { busy, run } = useAction();
  const part = transfer.total > 0 ? transfer.bytes / transfer.total : transfer.state === "done" ? 1 : null;
  const left = transfer.rate && transfer.rate > 0 && transfer.state === "sending" ? (transfer.total - transfer.bytes) / transfer.rate : null;
  return (
    <li data-transfer={transfer.id} data-state={transfer.state} data-machine-id={transfer.machine}>
      <b>{machine}</b>
      <span className="dim">{program ? `${program} · ` : ""}{t(`transfer.${transfer.kind}`)}{transfer.revision ? ` · ${t("programs.revision_n", { number: transfer.revision })}` : ""}</span>
      <Progress part={part} label={machine} state={transfer.state} />
      <span className="num dim">{isOver(transfer) ? moment(transfer.ended) : `${percent(part)} · ${bytes(transfer.bytes)}${left !== null ? ` · ${t("programs.eta", { time: duration(left) })}` : ""}`}</span>
      <span className={`chip ${transfer.state === "done" ? "good" : transfer.state === "failed" ? "bad" : transfer.state === "waiting" ? "warn" : ""}`}>{t(`transfer.${transfer.state}`, { defaultValue: transfer.state })}</span>
      <span className="transfer-reason">{transfer.state !== "done" && reasonText(transfer.reason)}
        {!isOver(transfer) && operator && <Button small kind="quiet" busy={busy} onClick={() => run(async () => { await remove(`/transfers/${transfer.id}`); })}>{t("transfer.cancel")}</Button>}</span>
    </li>);
}

export function Transfers({ program, limit }: { program?: number; limit: number }) {
  const { t } = useTranslation();
  const live = useTransfers();
  const machines = useShop((shop) => shop.machines);
  const { value: listed } = useLoad((signal) => list<Transfer>(`/transfers?limit=200`, signal), [program]);
  const { value: all } = useLoad((signal) => list<Machine>("/machines", signal), []);
  const { value: programs } = useLoad((signal) => (program ? Promise.resolve([]) : list<Program>("/programs?limit=500", signal)), [program]);
  const merged = new Map((listed ?? []).map((one) => [one.id, one]));
  for (const one of live.values()) merged.set(one.id, one);
  const rows = [...merged.values()].filter((one) => !program || one.program === program).sort((a, b) => b.id - a.id).slice(0, limit);
  const name = (id: number) => machines.get(id)?.name ?? all?.find((one) => one.id === id)?.name ?? String(id);
  if (rows.length === 0) return <div className="empty small">{t("programs.transfers_none")}</div>;
  return <ul className="transfers">{rows.map((one) => <TransferRow key={one.id} transfer={one} machine={name(one.machine)} program={programs?.find((p) => p.id === one.program)?.name} />)}</ul>;
}
