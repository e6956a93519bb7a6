// Orders with what is made of them, and the counts: where witnesses disagreed, and everything counted again.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { list, post } from "../../api/client";
import type { Machine } from "../../api/types";
import { moment } from "../../format/time";
import { useLoad, useShop } from "../../live/hooks";
import { useMay } from "../../shell/session";
import { Button, CsvLink, Dialog, Field, Panel, Progress, toast, useAction } from "../../ui/parts";

interface Order { id: number; name: string; machine: number | null; program: string; required: number; from: string; made: number; rejected: number }
interface Disagreement { id: number; machine: number; at: string; kind: "counter_step" | "run_parts"; counted: number; witness: number; seen_by: string | null }
interface Recount { machine: number; machine_name: string; events: number; missing: number; parts: number; parts_stored: number; runs: number; runs_stored: number; identical: boolean; differences: string[] }

export function Orders({ machines, names }: { machines: Machine[]; names: Map<number, string> }) {
  const { t } = useTranslation();
  const parts = useShop((shop) => shop.partsSeen);
  const { value: orders, reload } = useLoad((signal) => list<Order>("/orders?open=1", signal), [parts]);
  const operator = useMay("operator");
  const [making, setMaking] = useState(false);
  const { busy, run } = useAction();
  const make = (form: FormData) => run(async () => {
    const machine = Number(form.get("machine"));
    await post("/orders", { name: String(form.get("name")), program: String(form.get("program")), required: Number(form.get("required")), machine: machine || null });
    setMaking(false);
    reload();
  });
  return (
    <Panel name="orders" title={t("data.orders")} extra={<>{operator && <Button small icon="plus" data-action="new-order" onClick={() => setMaking(true)}>{t("data.new_order")}</Button>}<CsvLink path="/orders" /></>}>
      <div className="table-box"><table className="table"><thead><tr><th>{t("data.order")}</th><th>{t("alarms.machine")}</th><th>{t("machine.program")}</th><th>{t("data.made")}</th><th className="right">{t("times.rejects")}</th><th>{t("data.since")}</th><th /></tr></thead>
        <tbody>{(orders ?? []).map((one) => (
          <tr key={one.id} data-order={one.name}><td><b>{one.name}</b></td><td>{one.machine === null ? t("data.any") : names.get(one.machine) ?? one.machine}</td><td>{one.program || t("data.any")}</td>
            <td className="life-bar"><Progress part={(one.made - one.rejected) / one.required} state="running" label={t("data.made")} /><span className="num">{one.made - one.rejected} / {one.required}</span></td>
            <td className="num right">{one.rejected || ""}</td><td className="num">{moment(one.from)}</td>
            <td className="row-actions">{operator && <Button small busy={busy} onClick={() => run(async () => { await post(`/orders/${one.id}/close`); reload(); })}>{t("data.close_order")}</Button>}</td></tr>))}</tbody></table>
        {orders?.length === 0 && <div className="empty small">{t("data.no_orders")}</div>}</div>
      {making && (
        <Dialog name="order" title={t("data.new_order")} onClose={() => setMaking(false)} actions={<><Button onClick={() => setMaking(false)}>{t("common.cancel")}</Button><Button kind="primary" type="submit" form="order-form" busy={busy}>{t("common.save")}</Button></>}>
          <form id="order-form" onSubmit={(event) => { event.preventDefault(); make(new FormData(event.currentTarget)); }}>
            <Field label={t("data.order")}><input name="name" required maxLength={100} autoFocus /></Field>
            <Field label={t("alarms.machine")}><select name="machine"><option value="">{t("data.any")}</option>{machines.map((one) => <option key={one.id} value={one.id}>{one.name}</option>)}</select></Field>
            <Field label={t("machine.program")} hint={t("data.any_program")}><input name="program" maxLength={200} placeholder="O1001" /></Field>
            <Field label={t("machine.required")}><input name="required" type="number" min={1} max={99_999_999} required /></Field></form>
        </Dialog>)}
    </Panel>
  );
}

export function Counts({ names }: { names: Map<number, string> }) {
  const { t } = useTranslation();
  const parts = useShop((shop) => shop.partsSeen);
  const { value, reload } = useLoad((signal) => list<Disagreement>("/counts/disagreements", signal), [parts]);
  const [counted, setCounted] = useState<Recount[] | null>(null);
  const operator = useMay("operator");
  const { busy, run } = useAction();
  const unseen = (value ?? []).filter((one) => one.seen_by === null);
  return (
    <Panel name="counts" title={t("data.counts")} extra={<><CsvLink path="/counts/disagreements" /><Button small busy={busy} data-action="recount" onClick={() => run(async () => {
      const found = await list<Recount>("/counts/recount");
      setCounted(found);
      toast(found.every((one) => one.identical) ? "good" : "error", t(found.every((one) => one.identical) ? "data.recount_same" : "data.recount_differs"));
    })}>{t("data.recount")}</Button></>}>
      {unseen.length === 0 && !counted && <div className="empty small">{t("data.witnesses_agree")}</div>}
      {unseen.map((one) => (
        <div key={one.id} className="request" data-disagreement={one.id}><span><b>{names.get(one.machine) ?? one.machine}</b> · {moment(one.at)} · {t(`data.disagree_${one.kind}`, { counted: one.counted, witness: one.witness })}</span>
          {operator && <Button small busy={busy} onClick={() => run(async () => { await post(`/counts/disagreements/${one.id}/seen`); reload(); })}>{t("data.seen")}</Button>}</div>))}
      {counted && <div className="table-box"><table className="table"><thead><tr><th>{t("alarms.machine")}</th><th className="right">{t("data.events")}</th><th className="right">{t("data.missing")}</th><th className="right">{t("times.parts")}</th><th className="right">{t("machine.runs")}</th><th /></tr></thead>
        <tbody>{counted.map((one) => (
          <tr key={one.machine} data-recount={one.machine}><td>{one.machine_name}</td><td className="num right">{one.events}</td><td className="num right">{one.missing || ""}</td><td className="num right">{one.parts} / {one.parts_stored}</td><td className="num right">{one.runs} / {one.runs_stored}</td>
            <td><span className={`chip ${one.identical ? "good" : "bad"}`} title={one.differences.join("\n")}>{t(one.identical ? "data.identical" : "data.differs")}</span></td></tr>))}</tbody></table></div>}
    </Panel>
  );
}
