// Who is told of alarms, and the mail server and secret that it goes by.
import { useState, type FormEvent } from "react";
import { useTranslation } from "react-i18next";
import { get, list, patch, post, remove } from "../../api/client";
import type { Machine } from "../../api/types";
import { useLoad } from "../../live/hooks";
import { Button, Dialog, ErrorNote, Field, Panel, toast, useAction } from "../../ui/parts";

interface Rule {
  id: number; name: string; machine: number | null; group: number | null; code: string; after_s: number; email: string; webhook: string;
  escalate_after_s: number; escalate_email: string; escalate_webhook: string; again_after_s: number; enabled: boolean;
}
interface Group { id: number; name: string }
interface Settings { mail_url: string; mail_user: string; mail_password_set: boolean; mail_from: string; mail_tls: boolean; webhook_secret_set: boolean; link: string }

export function Messages() {
  const { t } = useTranslation();
  const { value: rules, error, reload } = useLoad((signal) => list<Rule>("/alarm-rules", signal), []);
  const { value: machines } = useLoad((signal) => list<Machine>("/machines", signal), []);
  const { value: groups } = useLoad((signal) => list<Group>("/machine-groups", signal), []);
  const [open, setOpen] = useState<Rule | "new" | null>(null);
  const place = (rule: Rule) => rule.machine ? machines?.find((one) => one.id === rule.machine)?.name : rule.group ? groups?.find((one) => one.id === rule.group)?.name : t("alarms.every_machine");
  return (
    <>
      <ErrorNote error={error} />
      <Panel className="flush" title={t("rules.title")} extra={<Button small kind="primary" icon="plus" onClick={() => setOpen("new")}>{t("rules.add")}</Button>}>
        <table className="table">
          <thead><tr><th>{t("rules.name")}</th><th>{t("alarms.machine")}</th><th>{t("rules.code")}</th><th>{t("rules.to")}</th><th>{t("rules.escalation")}</th><th>{t("users.status")}</th><th /></tr></thead>
          <tbody>{(rules ?? []).map((rule) => (
            <tr key={rule.id} data-rule={rule.name} className={rule.enabled ? "" : "muted"}><td><b>{rule.name}</b></td><td>{place(rule)}</td><td className="mono">{rule.code || "*"}</td>
              <td className="grow">{[rule.email, rule.webhook].filter(Boolean).join(", ")}</td>
              <td>{rule.escalate_after_s > 0 ? t("rules.after_min", { minutes: Math.round(rule.escalate_after_s / 60) }) : "–"}</td>
              <td>{t(rule.enabled ? "users.active" : "rules.off")}</td>
              <td className="row-actions"><Button small kind="quiet" icon="edit" aria-label={t("rules.edit", { name: rule.name })} onClick={() => setOpen(rule)} /></td></tr>
          ))}</tbody>
        </table>
        {rules?.length === 0 && <div className="empty">{t("rules.none")}</div>}
      </Panel>
      <MessageSettings />
      {open && <EditRule rule={open === "new" ? null : open} machines={machines ?? []} groups={groups ?? []} onClose={() => setOpen(null)} onDone={() => { setOpen(null); reload(); }} />}
    </>
  );
}

function EditRule({ rule, machines, groups, onClose, onDone }: { rule: Rule | null; machines: Machine[]; groups: Group[]; onClose: () => void; onDone: () => void }) {
  const { t } = useTranslation();
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const submit = (event: FormEvent<HTMLFormElement>) => {
    event.preventDefault();
    const data = new FormData(event.currentTarget);
    const text = (name: string) => String(data.get(name) ?? "").trim();
    const where = text("where");
    const fields = {
      name: text("name"), code: text("code"), email: text("email"), webhook: text("webhook"), escalate_email: text("escalate_email"), escalate_webhook: rule?.escalate_webhook ?? "",
      machine: where.startsWith("m") ? Number(where.slice(1)) : null, group: where.startsWith("g") ? Number(where.slice(1)) : null,
      after_s: Number(text("after_s")), escalate_after_s: Math.round(Number(text("escalate_min")) * 60), again_after_s: Math.round(Number(text("again_min")) * 60), enabled: data.get("enabled") === "on",
    };
    setBusy(true);
    (rule ? patch(`/alarm-rules/${rule.id}`, fields) : post("/alarm-rules", fields)).then(onDone, setError).finally(() => setBusy(false));
  };
  return (
    <Dialog wide name="rule" title={rule ? t("rules.edit", { name: rule.name }) : t("rules.add")} onClose={onClose} actions={<>
      {rule && <Button kind="danger" onClick={() => { remove(`/alarm-rules/${rule.id}`).then(onDone, setError); }}>{t("common.remove")}</Button>}
      <Button onClick={onClose}>{t("common.cancel")}</Button>
      <Button kind="primary" type="submit" form="rule-form" busy={busy}>{t("common.save")}</Button></>}>
      <form id="rule-form" className="form two" onSubmit={submit}>
        <Field label={t("rules.name")}><input name="name" required autoFocus maxLength={100} defaultValue={rule?.name ?? ""} /></Field>
        <Field label={t("alarms.machine")}><select name="where" defaultValue={rule?.machine ? `m${rule.machine}` : rule?.group ? `g${rule.group}` : ""}>
          <option value="">{t("alarms.every_machine")}</option>
          {groups.map((group) => <option key={group.id} value={`g${group.id}`}>{group.name}</option>)}
          {machines.map((machine) => <option key={machine.id} value={`m${machine.id}`}>{machine.name}</option>)}</select></Field>
        <Field label={t("rules.code")} hint={t("rules.code_hint")}><input name="code" className="mono" defaultValue={rule?.code ?? ""} /></Field>
        <Field label={t("rules.after_s")} hint={t("rules.after_hint")}><input name="after_s" type="number" min={0} defaultValue={rule?.after_s ?? 0} /></Field>
        <Field label={t("rules.email")} hint={t("rules.many")}><input name="email" defaultValue={rule?.email ?? ""} /></Field>
        <Field label={t("rules.webhook")}><input name="webhook" placeholder="https://" defaultValue={rule?.webhook ?? ""} /></Field>
        <Field label={t("rules.escalate_min")} hint={t("rules.escalate_hint")}><input name="escalate_min" type="number" min={0} step="any" defaultValue={(rule?.escalate_after_s ?? 0) / 60} /></Field>
        <Field label={t("rules.escalate_email")}><input name="escalate_email" defaultValue={rule?.escalate_email ?? ""} /></Field>
        <Field label={t("rules.again_min")} hint={t("rules.again_hint")}><input name="again_min" type="number" min={0} step="any" defaultValue={(rule?.again_after_s ?? 300) / 60} /></Field>
        <label className="check"><input type="checkbox" name="enabled" defaultChecked={rule?.enabled ?? true} />{t("rules.enabled")}</label>
        <ErrorNote error={error} />
      </form>
    </Dialog>
  );
}

function MessageSettings() {
  const { t } = useTranslation();
  const { value: settings, error, reload } = useLoad((signal) => get<Settings>("/settings/messages", signal), []);
  const [problem, setProblem] = useState<unknown>(null);
  const [target, setTarget] = useState("");
  const { busy, run } = useAction();
  if (!settings) return <ErrorNote error={error} />;
  const submit = (event: FormEvent<HTMLFormElement>) => {
    event.preventDefault();
    const data = new FormData(event.currentTarget);
    const text = (name: string) => String(data.get(name) ?? "").trim();
    patch("/settings/messages", {
      mail_url: text("mail_url"), mail_user: text("mail_user"), mail_password: text("mail_password"), mail_from: text("mail_from"),
      mail_tls: data.get("mail_tls") === "on", webhook_secret: text("webhook_secret"), link: text("link"),
    }).then(() => { setProblem(null); toast("good", t("admin.saved")); reload(); }, setProblem);
  };
  const kept = (set: boolean) => (set ? t("rules.kept") : "");
  return (
    <Panel title={t("rules.settings")} name="message-settings">
      <form className="form two" onSubmit={submit}>
        <Field label={t("rules.mail_url")} hint="smtp://mail.example.com:587"><input name="mail_url" defaultValue={settings.mail_url} /></Field>
        <Field label={t("rules.mail_from")}><input name="mail_from" defaultValue={settings.mail_from} /></Field>
        <Field label={t("signin.user")}><input name="mail_user" autoComplete="off" defaultValue={settings.mail_user} /></Field>
        <Field label={t("signin.password")} hint={kept(settings.mail_password_set)}><input name="mail_password" type="password" autoComplete="new-password" /></Field>
        <Field label={t("rules.webhook_secret")} hint={kept(settings.webhook_secret_set)}><input name="webhook_secret" type="password" autoComplete="new-password" /></Field>
        <Field label={t("rules.link")} hint={t("rules.link_hint")}><input name="link" defaultValue={settings.link} placeholder={location.origin} /></Field>
        <label className="check"><input type="checkbox" name="mail_tls" defaultChecked={settings.mail_tls} />{t("rules.mail_tls")}</label>
        <Button type="submit" kind="primary">{t("common.save")}</Button>
        <ErrorNote error={problem} />
      </form>
      <div className="filters">
        <label><span>{t("rules.test_to")}</span><input name="test-target" value={target} onChange={(event) => setTarget(event.target.value)} /></label>
        <Button busy={busy} disabled={target === ""} onClick={() => run(async () => {
          const answer = await post<{ delivered: boolean; problem: string }>("/settings/messages/test", { kind: target.startsWith("http") ? "webhook" : "email", target });
          toast(answer.delivered ? "good" : "error", answer.delivered ? t("rules.delivered") : answer.problem);
        })}>{t("rules.test")}</Button>
      </div>
    </Panel>
  );
}
