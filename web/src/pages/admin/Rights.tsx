// Rights beyond the role: on one machine, a group of machines, or for one action. And the groups themselves.
import { useState, type FormEvent } from "react";
import { useTranslation } from "react-i18next";
import { get, list, patch, post, remove } from "../../api/client";
import { roles, type Machine, type User } from "../../api/types";
import { useLoad } from "../../live/hooks";
import { Button, Dialog, ErrorNote, Field, Note, Panel, toast, useAction } from "../../ui/parts";

interface Grant { machine: number | null; group: number | null; role: string | null; action: string | null; allow: boolean }
interface Group { id: number; name: string; machines: number[] }
interface Permission { action: string; role: string }

export function Rights() {
  const { t } = useTranslation();
  const { value: users, error } = useLoad((signal) => list<User>("/users", signal), []);
  const { value: machines } = useLoad((signal) => list<Machine>("/machines", signal), []);
  const { value: groups, reload: reloadGroups } = useLoad((signal) => list<Group>("/machine-groups", signal), []);
  const { value: permissions } = useLoad((signal) => list<Permission>("/permissions", signal), []);
  const [user, setUser] = useState<User | null>(null);
  const [group, setGroup] = useState<Group | "new" | null>(null);
  const name = (id: number) => machines?.find((machine) => machine.id === id)?.name ?? String(id);
  return (
    <>
      <ErrorNote error={error} />
      <Note>{t("rights.explained")}</Note>
      <Panel className="flush" title={t("rights.people")}>
        <table className="table"><tbody>
          {(users ?? []).map((row) => (
            <tr key={row.id} data-user={row.user}><td><b>{row.user}</b></td><td>{row.name}</td><td>{t(`role.${row.role}`)}</td>
              <td className="row-actions"><Button small icon="edit" onClick={() => setUser(row)}>{t("rights.edit")}</Button></td></tr>
          ))}
        </tbody></table>
      </Panel>
      <Panel className="flush" title={t("rights.groups")} extra={<Button small icon="plus" onClick={() => setGroup("new")}>{t("rights.add_group")}</Button>}>
        <table className="table"><tbody>
          {(groups ?? []).map((row) => (
            <tr key={row.id} data-group={row.name}><td><b>{row.name}</b></td><td className="grow">{row.machines.map(name).join(", ")}</td>
              <td className="row-actions"><Button small kind="quiet" icon="edit" aria-label={t("rights.edit_group", { name: row.name })} onClick={() => setGroup(row)} /></td></tr>
          ))}
        </tbody></table>
        {groups?.length === 0 && <div className="empty">{t("rights.no_groups")}</div>}
      </Panel>
      {user && machines && groups && permissions && <EditGrants user={user} machines={machines} groups={groups} permissions={permissions} onClose={() => setUser(null)} />}
      {group && machines && <EditGroup group={group === "new" ? null : group} machines={machines} onClose={() => setGroup(null)} onDone={() => { setGroup(null); reloadGroups(); }} />}
    </>
  );
}

function EditGrants({ user, machines, groups, permissions, onClose }: {
  user: User; machines: Machine[]; groups: Group[]; permissions: Permission[]; onClose: () => void;
}) {
  const { t } = useTranslation();
  const { value: loaded } = useLoad((signal) => get<{ items: Grant[] }>(`/users/${user.id}/grants`, signal), [user.id]);
  const [changed, setChanged] = useState<Grant[] | null>(null);
  const [error, setError] = useState<unknown>(null);
  const { busy, run } = useAction();
  const grants = changed ?? loaded?.items ?? [];
  const set = (at: number, part: Partial<Grant>) => setChanged(grants.map((grant, i) => (i === at ? { ...grant, ...part } : grant)));
  const where = (grant: Grant) => (grant.machine ? `m${grant.machine}` : grant.group ? `g${grant.group}` : "");
  const what = (grant: Grant) => (grant.role ? `r:${grant.role}` : `${grant.allow ? "a" : "n"}:${grant.action}`);
  const save = () => run(async () => {
    try {
      await patch(`/users/${user.id}/grants`, { grants });
      toast("good", t("rights.saved", { user: user.user }));
      onClose();
    } catch (problem) { setError(problem); }
  });
  return (
    <Dialog wide name="grants" title={t("rights.of", { user: user.user })} onClose={onClose} actions={<>
      <Button onClick={onClose}>{t("common.cancel")}</Button>
      <Button kind="primary" busy={busy} onClick={save}>{t("common.save")}</Button></>}>
      <p>{t("rights.base", { role: t(`role.${user.role}`) })}</p>
      {grants.map((grant, at) => (
        <div key={at} className="grant-row" data-grant={at}>
          <select aria-label={t("rights.what")} value={what(grant)} onChange={(event) => {
            const [kind, value = ""] = event.target.value.split(":");
            set(at, kind === "r" ? { role: value, action: null, allow: true } : { role: null, action: value, allow: kind === "a" });
          }}>
            <optgroup label={t("rights.role")}>{roles.slice(1).map((role) => <option key={role} value={`r:${role}`}>{t(`role.${role}`)}</option>)}</optgroup>
            <optgroup label={t("rights.allowed")}>{permissions.map(({ action }) => <option key={action} value={`a:${action}`}>{t(`action.${action}`, action)}</option>)}</optgroup>
            <optgroup label={t("rights.forbidden")}>{permissions.map(({ action }) => <option key={action} value={`n:${action}`}>{t("rights.negated", { action: t(`action.${action}`, action) })}</option>)}</optgroup>
          </select>
          <select aria-label={t("rights.where")} value={where(grant)} onChange={(event) => {
            const id = Number(event.target.value.slice(1));
            set(at, { machine: event.target.value.startsWith("m") ? id : null, group: event.target.value.startsWith("g") ? id : null });
          }}>
            <option value="">{t("rights.everywhere")}</option>
            <optgroup label={t("rights.groups")}>{groups.map((group) => <option key={group.id} value={`g${group.id}`}>{group.name}</option>)}</optgroup>
            <optgroup label={t("alarms.machine")}>{machines.map((machine) => <option key={machine.id} value={`m${machine.id}`}>{machine.name}</option>)}</optgroup>
          </select>
          <Button small kind="quiet" icon="trash" aria-label={t("common.remove")} onClick={() => setChanged(grants.filter((_, i) => i !== at))} />
        </div>
      ))}
      <Button small icon="plus" onClick={() => setChanged([...grants, { machine: null, group: null, role: "operator", action: null, allow: true }])}>{t("rights.add")}</Button>
      <ErrorNote error={error} />
    </Dialog>
  );
}

function EditGroup({ group, machines, onClose, onDone }: { group: Group | null; machines: Machine[]; onClose: () => void; onDone: () => void }) {
  const { t } = useTranslation();
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const submit = (event: FormEvent<HTMLFormElement>) => {
    event.preventDefault();
    const data = new FormData(event.currentTarget);
    const fields = { name: data.get("name"), machines: data.getAll("machine").map(Number) };
    setBusy(true);
    (group ? patch(`/machine-groups/${group.id}`, fields) : post("/machine-groups", fields)).then(onDone, setError).finally(() => setBusy(false));
  };
  return (
    <Dialog name="group" title={group ? t("rights.edit_group", { name: group.name }) : t("rights.add_group")} onClose={onClose} actions={<>
      {group && <Button kind="danger" onClick={() => { remove(`/machine-groups/${group.id}`).then(onDone, setError); }}>{t("common.remove")}</Button>}
      <Button onClick={onClose}>{t("common.cancel")}</Button>
      <Button kind="primary" type="submit" form="group-form" busy={busy}>{t("common.save")}</Button></>}>
      <form id="group-form" className="form" onSubmit={submit}>
        <Field label={t("rules.name")}><input name="name" required defaultValue={group?.name ?? ""} maxLength={60} autoFocus /></Field>
        <div className="check-grid">{machines.map((machine) => (
          <label key={machine.id} className="check"><input type="checkbox" name="machine" value={machine.id} defaultChecked={group?.machines.includes(machine.id) ?? false} />{machine.name}</label>
        ))}</div>
        <ErrorNote error={error} />
      </form>
    </Dialog>
  );
}
