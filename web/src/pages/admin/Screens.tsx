// Wall screens that look without a person, and how long people stay signed in.
import { useState, type FormEvent } from "react";
import { useTranslation } from "react-i18next";
import { get, list, patch, post, remove } from "../../api/client";
import { roles, type Role } from "../../api/types";
import { moment } from "../../format/time";
import { useLoad } from "../../live/hooks";
import { Button, Dialog, ErrorNote, Field, Note, Panel, toast, useAction } from "../../ui/parts";

interface ViewToken { id: number; name: string; by: string; created: string; expires: string | null; last_used: string | null }
interface Policy { session_hours: number; idle_minutes: number; least_password: number }

export function Screens() {
  const { t } = useTranslation();
  const { value: tokens, error, reload } = useLoad((signal) => list<ViewToken>("/view-tokens", signal), []);
  const [adding, setAdding] = useState(false);
  const { busy, run } = useAction();
  return (
    <>
      <ErrorNote error={error} />
      <Panel className="flush" title={t("screens.title")} extra={<Button small kind="primary" icon="plus" onClick={() => setAdding(true)}>{t("screens.add")}</Button>}>
        <p className="panel-text">{t("screens.explained")}</p>
        <table className="table">
          <thead><tr><th>{t("rules.name")}</th><th>{t("screens.by")}</th><th>{t("screens.created")}</th><th>{t("screens.last_used")}</th><th /></tr></thead>
          <tbody>{(tokens ?? []).map((token) => (
            <tr key={token.id} data-screen={token.name}><td><b>{token.name}</b></td><td>{token.by}</td><td className="num">{moment(token.created)}</td>
              <td className="num">{token.last_used ? moment(token.last_used) : t("users.never")}</td>
              <td className="row-actions"><Button small kind="quiet" icon="trash" busy={busy} aria-label={t("screens.revoke", { name: token.name })}
                onClick={() => run(async () => { await remove(`/view-tokens/${token.id}`); reload(); })} /></td></tr>
          ))}</tbody>
        </table>
        {tokens?.length === 0 && <div className="empty">{t("screens.none")}</div>}
      </Panel>
      <SignInPolicy />
      <Provider />
      {adding && <AddScreen onClose={() => { setAdding(false); reload(); }} />}
    </>
  );
}

function AddScreen({ onClose }: { onClose: () => void }) {
  const { t } = useTranslation();
  const [error, setError] = useState<unknown>(null);
  const [made, setMade] = useState<string | null>(null);
  const submit = (event: FormEvent<HTMLFormElement>) => {
    event.preventDefault();
    const name = String(new FormData(event.currentTarget).get("name"));
    post<{ token: string }>("/view-tokens", { name }).then((answer) => setMade(`${location.origin}${location.pathname}#/screen/${answer.token}`), setError);
  };
  return (
    <Dialog name="screen" title={t("screens.add")} onClose={onClose} actions={made
      ? <Button kind="primary" onClick={onClose}>{t("common.done")}</Button>
      : <><Button onClick={onClose}>{t("common.cancel")}</Button><Button kind="primary" type="submit" form="screen-form">{t("common.create")}</Button></>}>
      {made
        ? <><p>{t("screens.once")}</p><textarea className="mono" readOnly rows={4} value={made} data-screen-address onFocus={(event) => event.target.select()} /></>
        : <form id="screen-form" className="form" onSubmit={submit}>
          <Field label={t("rules.name")} hint={t("screens.name_hint")}><input name="name" required maxLength={60} autoFocus /></Field>
          <ErrorNote error={error} /></form>}
    </Dialog>
  );
}

function SignInPolicy() {
  const { t } = useTranslation();
  const { value: policy, error, reload } = useLoad((signal) => get<Policy>("/settings/sign-in", signal), []);
  const [problem, setProblem] = useState<unknown>(null);
  if (!policy) return <ErrorNote error={error} />;
  const submit = (event: FormEvent<HTMLFormElement>) => {
    event.preventDefault();
    const data = new FormData(event.currentTarget);
    const number = (name: string) => Number(data.get(name));
    patch("/settings/sign-in", { session_hours: number("session_hours"), idle_minutes: number("idle_minutes"), least_password: number("least_password") })
      .then(() => { setProblem(null); toast("good", t("admin.saved")); reload(); }, setProblem);
  };
  return (
    <Panel title={t("policy.title")} name="policy">
      <form className="form inline" onSubmit={submit}>
        <Field label={t("policy.session_hours")}><input name="session_hours" type="number" min={1} max={168} defaultValue={policy.session_hours} /></Field>
        <Field label={t("policy.idle_minutes")} hint={t("policy.idle_hint")}><input name="idle_minutes" type="number" min={0} max={1440} defaultValue={policy.idle_minutes} /></Field>
        <Field label={t("policy.least_password")}><input name="least_password" type="number" min={8} max={64} defaultValue={policy.least_password} /></Field>
        <Button type="submit" kind="primary">{t("common.save")}</Button>
        <ErrorNote error={problem} />
      </form>
      <Note>{t("policy.lock")}</Note>
    </Panel>
  );
}

interface ProviderSettings { issuer: string; client_id: string; client_secret_set: boolean; label: string; create: boolean; role: Role }

/// Signing in through an OpenID Connect provider, beside passwords.
function Provider() {
  const { t } = useTranslation();
  const { value: provider, error, reload } = useLoad((signal) => get<ProviderSettings>("/settings/provider", signal), []);
  const [problem, setProblem] = useState<unknown>(null);
  if (!provider) return <ErrorNote error={error} />;
  const submit = (event: FormEvent<HTMLFormElement>) => {
    event.preventDefault();
    const data = new FormData(event.currentTarget);
    const text = (name: string) => String(data.get(name) ?? "").trim();
    patch("/settings/provider", { issuer: text("issuer"), client_id: text("client_id"), client_secret: text("client_secret"), label: text("label"), role: text("role"), create: data.get("create") === "on" })
      .then(() => { setProblem(null); toast("good", t("admin.saved")); reload(); }, setProblem);
  };
  return (
    <Panel title={t("provider.title")} name="provider">
      <form className="form two" onSubmit={submit}>
        <Field label={t("provider.issuer")} hint={t("provider.issuer_hint")}><input name="issuer" placeholder="https://" defaultValue={provider.issuer} /></Field>
        <Field label={t("provider.label")}><input name="label" defaultValue={provider.label} /></Field>
        <Field label={t("provider.client_id")}><input name="client_id" autoComplete="off" defaultValue={provider.client_id} /></Field>
        <Field label={t("provider.client_secret")} hint={provider.client_secret_set ? t("rules.kept") : ""}><input name="client_secret" type="password" autoComplete="new-password" /></Field>
        <Field label={t("provider.role")}><select name="role" defaultValue={provider.role}>{roles.map((role) => <option key={role} value={role}>{t(`role.${role}`)}</option>)}</select></Field>
        <label className="check"><input type="checkbox" name="create" defaultChecked={provider.create} />{t("provider.create")}</label>
        <Button type="submit" kind="primary">{t("common.save")}</Button>
        <ErrorNote error={problem} />
      </form>
    </Panel>
  );
}
