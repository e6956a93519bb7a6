// A plan first, then the sending: each machine chosen, each with its own progress, result and reason.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { list, post } from "../../api/client";
import type { Distribution, Machine, Program, Resident, Revision, Transfer } from "../../api/types";
import { useLoad, useMachine, useShop, useTransfers } from "../../live/hooks";
import { address } from "../../shell/router";
import { useMay } from "../../shell/session";
import { Button, Note, Panel, StateBadge, toast, useAction } from "../../ui/parts";
import { TransferRow, Transfers } from "./Transfers";

export function SendTab({ program, revision }: { program: Program; revision: Revision }) {
  const { t } = useTranslation();
  const programmer = useMay("programmer"), operator = useMay("operator");
  const { value: machines } = useLoad((signal) => list<Machine>("/machines", signal), []);
  const [chosen, setChosen] = useState<ReadonlySet<number>>(new Set());
  const [sent, setSent] = useState<Transfer[]>([]);
  const live = useTransfers();
  const { busy, run } = useAction();
  const all = machines ?? [];
  const toggle = (id: number) => setChosen((before) => { const after = new Set(before); if (!after.delete(id)) after.add(id); return after; });
  const send = () => run(async () => {
    const made = await post<Distribution>("/distributions", { program: program.id, revision: revision.number, machines: [...chosen] });
    setSent(made.transfers);
    setChosen(new Set());
  });
  const drip = (machine: Machine) => run(async () => {
    const made = await post<Transfer>(`/machines/${machine.id}/drip`, { program_id: program.id, revision: revision.number });
    setSent([made]);
    toast("good", t("programs.drip_started"));
  });
  return (
    <div className="send-tab">
      {!revision.released && <Note kind="warn">{t("programs.send_not_released", { number: revision.number })}</Note>}
      <Panel className="flush" name="send">
        <div className="records-bar padded"><b>{t("programs.send_choose")}</b>
          <label className="check"><input type="checkbox" checked={all.length > 0 && chosen.size === all.length} onChange={(event) => setChosen(event.target.checked ? new Set(all.map((one) => one.id)) : new Set())} />{t("programs.send_all")}</label>
          <span className="end"><Button kind="primary" icon="send" busy={busy} disabled={!programmer || chosen.size === 0} data-action="send" onClick={send}>{t("programs.send_now", { number: revision.number, count: chosen.size })}</Button></span></div>
        <table className="table"><tbody>{all.map((one) => <MachineRow key={one.id} machine={one} program={program} chosen={chosen.has(one.id)} onToggle={() => toggle(one.id)} operator={operator} busy={busy} onDrip={() => drip(one)} />)}</tbody></table>
      </Panel>
      <p className="dim">{t("programs.drip_explained")}</p>
      {sent.length > 0 && <Panel title={t("programs.send_result")} name="send-results"><ul className="transfers">{sent.map((one) => <TransferRow key={one.id} transfer={live.get(one.id) ?? one} machine={all.find((m) => m.id === one.machine)?.name ?? ""} />)}</ul></Panel>}
      <Panel title={t("programs.transfers")}><Transfers program={program.id} limit={20} /></Panel>
    </div>);
}

function MachineRow({ machine, program, chosen, onToggle, operator, busy, onDrip }: { machine: Machine; program: Program; chosen: boolean; onToggle: () => void; operator: boolean; busy: boolean; onDrip: () => void }) {
  const { t } = useTranslation();
  const { state, current } = useMachine(machine.id);
  const done = useShop((shop) => [...shop.transfers.values()].filter((one) => one.machine === machine.id && one.state === "done").length);
  const { value: residents } = useLoad((signal) => list<Resident>(`/machines/${machine.id}/programs`, signal).catch(() => []), [machine.id, done]);
  const here = residents?.find((one) => one.program_id === program.id);
  return (
    <tr data-send-to={machine.name}>
      <td><label className="check"><input type="checkbox" checked={chosen} onChange={onToggle} /><b>{machine.name}</b></label></td>
      <td className="dim">{machine.profile}</td><td><StateBadge state={state} /></td>
      <td>{here ? <span className={`chip ${here.stale ? "warn" : "good"}`}>{here.revision ? t("programs.revision_n", { number: here.revision }) : t("machine.resident")}</span> : null}</td>
      <td className="row-actions"><a className="button small quiet" href={address(["machines", machine.id])}>{t("programs.check_machine")}</a>
        <Button small disabled={!operator || !current} busy={busy} data-drip={machine.name} aria-label={t("programs.drip_to", { name: machine.name })} onClick={onDrip}>{t("programs.drip")}</Button></td></tr>);
}
