// A port's record: where it is, what its control speaks, what happens with what comes in.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { list, patch, post, remove } from "../../api/client";
import type { Machine } from "../../api/types";
import { inLanguage } from "../../i18n";
import { useLoad } from "../../live/hooks";
import { Button, Dialog, ErrorNote, Field } from "../../ui/parts";
import type { Port, PortSettings, Protocol } from "./types";

export function PortForm({ port, onClose }: { port: Port | null; onClose: () => void }) {
  const { t } = useTranslation();
  const { value: protocols } = useLoad((signal) => list<Protocol>("/serial-protocols", signal), []);
  const { value: machines } = useLoad((signal) => list<Machine>("/machines", signal), []);
  const [name, setName] = useState(port?.name ?? "");
  const [at, setAt] = useState(port?.address ?? "");
  const [machine, setMachine] = useState(port?.machine ?? 0);
  const [changed, setChanged] = useState<Partial<PortSettings>>({});
  const [protocol, setProtocol] = useState(port?.settings.protocol ?? "dc1-dc4");
  const [listens, setListens] = useState(port?.listens ?? false);
  const [nameRule, setNameRule] = useState(port?.name_rule ?? "number");
  const [folder, setFolder] = useState(port?.folder ?? "/");
  const [rule, setRule] = useState(port?.rules.map((one) => `${one.pattern}:${one.name}`).join("\n") ?? "");
  const [error, setError] = useState<unknown>(null);
  const row = protocols?.find((one) => one.name === protocol);
  const settings: PortSettings | undefined = row && { ...(port?.settings.protocol === protocol ? port.settings : row.settings), ...changed };
  const set = (field: string, value: unknown) => setChanged((before) => ({ ...before, [field]: value }));
  const save = () => {
    setError(null);
    const rules = rule.split("\n").map((one) => one.trim()).filter(Boolean).map((one) => {
      const colon = one.lastIndexOf(":");
      return { pattern: one.slice(0, colon), name: one.slice(colon + 1), action: one.includes("*") ? "send" : "list" };
    });
    const body = { name, address: at, machine: machine || null, settings, listens, folder, name_rule: nameRule, rules };
    (port ? patch(`/ports/${port.id}`, body) : post("/ports", body)).then(onClose, setError);
  };
  const number = (field: string, min: number, max: number) => (
    <Field label={t(`dnc.field_${field}`)}><input type="number" min={min} max={max} value={Number(settings?.[field] ?? 0)} data-field={field} onChange={(event) => set(field, Number(event.target.value))} /></Field>);
  const flag = (field: string) => (
    <label className="check"><input type="checkbox" checked={Boolean(settings?.[field])} data-field={field} onChange={(event) => set(field, event.target.checked)} />{t(`dnc.field_${field}`)}</label>);
  const choice = (field: string, values: string[]) => (
    <Field label={t(`dnc.field_${field}`)}><select value={String(settings?.[field] ?? "")} data-field={field} onChange={(event) => set(field, event.target.value)}>{values.map((one) => <option key={one}>{one}</option>)}</select></Field>);
  const words = (field: string, hint = "") => (
    <Field label={t(`dnc.field_${field}`)} hint={hint}><input className="mono" value={String(settings?.[field] ?? "")} data-field={field} onChange={(event) => set(field, event.target.value)} /></Field>);
  const agent = at.startsWith("agent:");
  return (
    <Dialog title={port ? t("dnc.edit_title", { name: port.name }) : t("dnc.add")} name="port" wide onClose={onClose} actions={<>
      {port && <span className="end-left"><Button kind="danger" icon="trash" onClick={() => remove(`/ports/${port.id}`).then(onClose, setError)}>{t("common.remove")}</Button></span>}
      <Button onClick={onClose}>{t("common.cancel")}</Button><Button kind="primary" data-action="save" disabled={!settings || !name || !at} onClick={save}>{t("common.save")}</Button></>}>
      <div className="form-grid">
        <Field label={t("dnc.field_name")}><input value={name} data-field="name" onChange={(event) => setName(event.target.value)} /></Field>
        <Field label={t("dnc.field_address")} hint={t(agent ? "dnc.agent_hint" : "dnc.address_hint")}><input className="mono" value={at} data-field="address" placeholder="/dev/ttyS0" onChange={(event) => setAt(event.target.value)} /></Field>
        {!agent && <><Field label={t("dnc.field_machine")} hint={t("dnc.machine_hint")}><select value={machine} onChange={(event) => setMachine(Number(event.target.value))}><option value={0}>{t("common.none")}</option>{machines?.map((one) => <option key={one.id} value={one.id}>{one.name}</option>)}</select></Field>
        <Field label={t("dnc.field_protocol")} hint={row ? inLanguage(row.text) : ""}><select value={protocol} data-field="protocol" onChange={(event) => { setProtocol(event.target.value); setChanged({}); }}>{protocols?.map((one) => <option key={one.name}>{one.name}</option>)}</select></Field>
        <Field label={t("dnc.field_line")} hint={t("dnc.line_hint")}><input className="mono" value={settings?.line ?? ""} data-field="line" onChange={(event) => set("line", event.target.value)} /></Field>
        {choice("code", ["iso", "eia", "ascii"])}
        {choice("end_of_block", ["lf", "crlf", "lfcrcr", "cr"])}
        {number("after_stop", 3, 4096)}{number("block_delay_ms", 0, 60000)}{number("start_limit_s", 0, 1000000)}{number("hold_limit_s", 0, 1000000)}
        <Field label={t("dnc.field_folder")}><input value={folder} onChange={(event) => setFolder(event.target.value)} /></Field>
        <Field label={t("dnc.field_name_rule")}><select value={nameRule} data-field="name_rule" onChange={(event) => setNameRule(event.target.value)}><option value="number">{t("dnc.name_number")}</option><option value="comment">{t("dnc.name_comment")}</option></select></Field></>}
      </div>
      {!agent && <><div className="form-flags">
        <label className="check"><input type="checkbox" checked={listens} data-field="listens" onChange={(event) => setListens(event.target.checked)} />{t("dnc.field_listens")}</label>
        {flag("frame")}{flag("pad_for_tv")}{flag("tv_check")}{flag("strip_spaces")}{flag("strip_comments")}{flag("strip_empty")}{flag("fold_case")}</div>
      <details className="form-more"><summary>{t("dnc.more")}</summary><div className="form-grid">
        {number("number_from", 0, 99999)}{number("number_step", 0, 1000)}{number("leader", 0, 10000)}{number("trailer", 0, 10000)}{number("quiet_ms", 100, 600000)}{number("punch_limit_s", 0, 1000000)}{number("most_bytes", 1, 268435456)}
        {words("symbols", t("dnc.symbols_hint"))}</div>
        <Field label={t("dnc.field_header")}><textarea className="mono" rows={2} value={String(settings?.header ?? "")} data-field="header" onChange={(event) => set("header", event.target.value)} /></Field></details></>}
      {!agent && listens && <Field label={t("dnc.field_rules")} hint={t("dnc.rules_hint")}><textarea className="mono" rows={2} value={rule} onChange={(event) => setRule(event.target.value)} placeholder="(GET=*):O*" /></Field>}
      <ErrorNote error={error} />
    </Dialog>
  );
}
