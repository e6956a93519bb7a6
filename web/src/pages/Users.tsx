import { useState, type FormEvent } from "react";
import { useTranslation } from "react-i18next";
import { list, patch, post, remove } from "../api/client";
import { roles, type Role, type User } from "../api/types";
import { moment } from "../format/time";
import { useLoad } from "../live/hooks";
import { useSession } from "../shell/session";
import { Button, CsvLink, Dialog, ErrorNote, Field, Note, Panel, toast, useAction } from "../ui/parts";

type Open = { kind: "edit"; user: User | null } | { kind: "remove"; user: User } | null;

export function Users() {
  const { t } = useTranslation();
  const session = useSession();
  const { value: users, error, reload } = useLoad((signal) => list<User>("/users", signal), []);
  const [open, setOpen] = useState<Open>(null);
  const { busy, run } = useAction();
  const done = () => { setOpen(null); reload(); };
  return (
    <div className="page-part" data-page="users">
      <div className="page-bar"><h1>{t("nav.users")}</h1>
        <span className="bar-end"><CsvLink path="/users" /><Button kind="primary" icon="plus" onClick={() => setOpen({ kind: "edit", user: null })}>{t("users.add")}</Button></span></div>
      <ErrorNote error={error} />
      <Panel className="flush">
        <table className="table">
          <thead><tr><th>{t("signin.user")}</th><th>{t("users.name")}</th><th>{t("users.role")}</th><th>{t("users.last")}</th><th>{t("users.status")}</th><th /></tr></thead>
          <tbody>
            {(users ?? []).map((user) => (
              <tr key={user.id} data-user={user.user} className={user.disabled ? "muted" : ""}>
                <td><b>{user.user}</b></td><td>{user.name}</td><td>{t(`role.${user.role}`)}</td>
                <td className="num">{user.last_sign_in ? moment(user.last_sign_in) : t("users.never")}</td>
                <td>{t(user.disabled ? "users.disabled" : "users.active")}</td>
                <td className="row-actions">
                  <Button small kind="quiet" icon="edit" aria-label={t("users.edit", { user: user.user })} onClick={() => setOpen({ kind: "edit", user })} />
                  <Button small kind="quiet" icon="trash" disabled={user.user === session.user} aria-label={t("users.remove", { user: user.user })} onClick={() => setOpen({ kind: "remove", user })} />
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      </Panel>
      <Panel title={t("users.roles_title")}>
        <dl className="facts roles">{roles.map((role) => <Explained key={role} role={role} />)}</dl>
      </Panel>
      {open?.kind === "edit" && <EditUser user={open.user} onClose={() => setOpen(null)} onDone={done} />}
      {open?.kind === "remove" && (
        <Dialog title={t("users.remove", { user: open.user.user })} onClose={() => setOpen(null)} actions={<>
          <Button onClick={() => setOpen(null)}>{t("common.cancel")}</Button>
          <Button kind="danger" busy={busy} onClick={() => run(async () => {
            await remove(`/users/${open.user.id}`);
            toast("good", t("users.removed", { user: open.user.user }));
            done();
          })}>{t("common.remove")}</Button></>}>
          <p>{t("users.remove_explained")}</p>
        </Dialog>
      )}
    </div>
  );
}

function Explained({ role }: { role: Role }) {
  const { t } = useTranslation();
  return <><dt>{t(`role.${role}`)}</dt><dd>{t(`role_may.${role}`)}</dd></>;
}

function EditUser({ user, onClose, onDone }: { user: User | null; onClose: () => void; onDone: () => void }) {
  const { t } = useTranslation();
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const submit = (event: FormEvent<HTMLFormElement>) => {
    event.preventDefault();
    const data = new FormData(event.currentTarget);
    const password = String(data.get("password") ?? "");
    const fields = {
      name: data.get("name"), role: data.get("role"), language: data.get("language"),
      ...(password ? { password } : {}),
    };
    setBusy(true);
    const sent = user ? patch(`/users/${user.id}`, { ...fields, disabled: data.get("disabled") === "on" })
      : post("/users", { ...fields, user: data.get("user") });
    sent.then(onDone, setError).finally(() => setBusy(false));
  };
  return (
    <Dialog title={user ? t("users.edit", { user: user.user }) : t("users.add")} name="user" onClose={onClose} actions={<>
      <Button onClick={onClose}>{t("common.cancel")}</Button>
      <Button kind="primary" type="submit" form="user-form" busy={busy}>{t("common.save")}</Button></>}>
      <form id="user-form" className="form" onSubmit={submit}>
        {!user && <Field label={t("signin.user")}><input name="user" required autoFocus autoCapitalize="none" spellCheck={false} maxLength={60} /></Field>}
        <Field label={t("users.name")}><input name="name" defaultValue={user?.name ?? ""} maxLength={100} /></Field>
        <Field label={t("users.role")}>
          <select name="role" defaultValue={user?.role ?? "viewer"}>{roles.map((role) => <option key={role} value={role}>{t(`role.${role}`)}</option>)}</select></Field>
        <Field label={t("nav.language")}>
          <select name="language" defaultValue={user?.language ?? "zh"}><option value="zh">中文</option><option value="en">English</option></select></Field>
        <Field label={t(user ? "users.new_password" : "signin.password")} hint={t("account.rule")}>
          <input name="password" type="password" autoComplete="new-password" minLength={8} required={!user} /></Field>
        {user && <label className="check"><input type="checkbox" name="disabled" defaultChecked={user.disabled} />{t("users.disable")}</label>}
        {!user && <Note>{t("users.first_password")}</Note>}
        <ErrorNote error={error} />
      </form>
    </Dialog>
  );
}
