// Backups that are kept, made and brought with one button each; restoring a machine; how long things stay.
import { useRef, useState, type FormEvent } from "react";
import { useTranslation } from "react-i18next";
import { get, list, patch, post, remove, upload } from "../../api/client";
import type { Machine } from "../../api/types";
import { moment } from "../../format/time";
import { useLoad } from "../../live/hooks";
import { Button, CsvLink, Dialog, ErrorNote, Field, Note, Panel, toast, useAction } from "../../ui/parts";

interface Backup { id: number; file: string; kind: "server" | "machine"; machine: number | null; sha256: string; bytes: number; by: string; at: string }
interface Restored {
  machine: number; of: string; made: string; machine_file: string; not_here: string[];
  programs: { name: string; state: string; reason?: string }[]; values: { state: string; in_backup: number; reason?: string; written?: number };
}
interface Keeping { events_days: number; states_days: number; transfers_days: number; backup_every_hours: number; backups_kept: number }

const size = (bytes: number) => (bytes < 1 << 20 ? `${Math.ceil(bytes / 1024)} KiB` : `${(bytes / (1 << 20)).toFixed(1)} MiB`);

export function Backups() {
  const { t } = useTranslation();
  const { value: backups, error, reload } = useLoad((signal) => list<Backup>("/backups", signal), []);
  const { value: machines } = useLoad((signal) => list<Machine>("/machines", signal), []);
  const [machine, setMachine] = useState("");
  const [restoring, setRestoring] = useState<Backup | null>(null);
  const file = useRef<HTMLInputElement>(null);
  const { busy, run } = useAction();
  const name = (id: number | null) => machines?.find((one) => one.id === id)?.name ?? (id === null ? "" : String(id));
  const make = (path: string) => run(async () => {
    const made = await post<Backup>(path);
    toast("good", t("backup.made", { file: made.file }));
    reload();
  });
  return (
    <>
      <div className="filters">
        <Button kind="primary" icon="download" busy={busy} data-action="backup-server" onClick={() => make("/backups")}>{t("backup.server_now")}</Button>
        <label><span>{t("alarms.machine")}</span>
          <select name="machine" value={machine} onChange={(event) => setMachine(event.target.value)}>
            <option value="">–</option>{(machines ?? []).map((one) => <option key={one.id} value={one.id}>{one.name}</option>)}</select></label>
        <Button busy={busy} disabled={machine === ""} data-action="backup-machine" onClick={() => make(`/machines/${machine}/backup`)}>{t("backup.machine_now")}</Button>
        <input ref={file} type="file" className="visually-hidden" aria-label={t("backup.bring")} accept=".zst" onChange={(event) => {
          const chosen = event.target.files?.[0];
          event.target.value = "";
          if (chosen) run(async () => { await upload<Backup>("/backups/file", chosen, () => undefined); toast("good", t("backup.brought", { file: chosen.name })); reload(); });
        }} />
        <Button icon="upload" busy={busy} onClick={() => file.current?.click()}>{t("backup.bring")}</Button>
        <CsvLink path="/backups" />
      </div>
      <ErrorNote error={error} />
      <Panel className="flush">
        <table className="table">
          <thead><tr><th>{t("backup.at")}</th><th>{t("backup.kind")}</th><th>{t("backup.size")}</th><th>{t("backup.by")}</th><th>{t("backup.file")}</th><th /></tr></thead>
          <tbody>{(backups ?? []).map((row) => (
            <tr key={row.id} data-backup={row.id} data-kind={row.kind}>
              <td className="num">{moment(row.at)}</td><td>{row.kind === "server" ? t("backup.whole_server") : name(row.machine) || t("alarms.machine")}</td><td className="num">{size(row.bytes)}</td><td>{row.by}</td>
              <td className="grow"><a href={`/api/v1/backups/${row.id}/file`} download={row.file} title={row.sha256}>{row.file}</a></td>
              <td className="row-actions">
                <Button small kind="quiet" icon="check" busy={busy} aria-label={t("backup.verify", { file: row.file })} onClick={() => run(async () => { await get(`/backups/${row.id}/verification`); toast("good", t("backup.is_whole", { file: row.file })); })} />
                {row.kind === "machine" && <Button small data-action="restore" onClick={() => setRestoring(row)}>{t("backup.restore")}</Button>}
                <Button small kind="quiet" icon="trash" busy={busy} aria-label={t("backup.remove", { file: row.file })} onClick={() => run(async () => { await remove(`/backups/${row.id}`); reload(); })} />
              </td></tr>
          ))}</tbody>
        </table>
        {backups?.length === 0 && <div className="empty">{t("backup.none")}</div>}
      </Panel>
      <Note>{t("backup.server_restore")}</Note>
      <KeepingForm />
      {restoring && machines && <Restore backup={restoring} machines={machines} onClose={() => setRestoring(null)} />}
    </>
  );
}

function Restore({ backup, machines, onClose }: { backup: Backup; machines: Machine[]; onClose: () => void }) {
  const { t } = useTranslation();
  const [machine, setMachine] = useState(String(machines.some((one) => one.id === backup.machine) ? backup.machine : ""));
  const [done, setDone] = useState<Restored | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const start = () => {
    setBusy(true);
    post<Restored>(`/machines/${machine}/restore`, { backup: backup.id }).then(setDone, setError).finally(() => setBusy(false));
  };
  return (
    <Dialog wide name="restore" title={t("backup.restore_title", { file: backup.file })} onClose={onClose} actions={done
      ? <Button kind="primary" onClick={onClose}>{t("common.done")}</Button>
      : <><Button onClick={onClose}>{t("common.cancel")}</Button><Button kind="danger" busy={busy} disabled={machine === ""} onClick={start}>{t("backup.restore")}</Button></>}>
      {!done && <div className="form">
        <Field label={t("backup.to")}><select name="target" value={machine} onChange={(event) => setMachine(event.target.value)}>
          <option value="">–</option>{machines.map((one) => <option key={one.id} value={one.id}>{one.name}</option>)}</select></Field>
        <Note kind="warn">{t("backup.restore_explained")}</Note><ErrorNote error={error} /></div>}
      {done && <div data-restored={done.machine}>
        <table className="table"><thead><tr><th>{t("backup.program")}</th><th>{t("backup.state")}</th></tr></thead>
          <tbody>{done.programs.map((program) => <tr key={program.name}><td className="mono">{program.name}</td><td>{t(`backup.state_${program.state}`, program.state)} {program.reason}</td></tr>)}</tbody></table>
        <p>{t("backup.values", { count: done.values.in_backup })}: {t(`backup.values_${done.values.state}`, done.values.state)}</p>
        {done.machine_file === "differs" && <Note kind="warn">{t("backup.file_differs")}</Note>}
        {done.not_here.length > 0 && <Note kind="warn">{t("backup.not_here", { names: done.not_here.join(", ") })}</Note>}
      </div>}
    </Dialog>
  );
}

const fields = ["backup_every_hours", "backups_kept", "states_days", "events_days", "transfers_days"] as const;

function KeepingForm() {
  const { t } = useTranslation();
  const { value: keeping, error, reload } = useLoad((signal) => get<Keeping>("/settings/keeping", signal), []);
  const [problem, setProblem] = useState<unknown>(null);
  if (!keeping) return <ErrorNote error={error} />;
  const submit = (event: FormEvent<HTMLFormElement>) => {
    event.preventDefault();
    const data = new FormData(event.currentTarget);
    patch("/settings/keeping", Object.fromEntries(fields.map((name) => [name, Number(data.get(name))])))
      .then(() => { setProblem(null); toast("good", t("admin.saved")); reload(); }, setProblem);
  };
  return (
    <Panel title={t("keeping.title")} name="keeping">
      <form className="form inline" onSubmit={submit}>
        {fields.map((name) => <Field key={name} label={t(`keeping.${name}`)}><input name={name} type="number" min={name === "backups_kept" ? 1 : 0} defaultValue={keeping[name]} /></Field>)}
        <Button type="submit" kind="primary">{t("common.save")}</Button>
        <ErrorNote error={problem} />
      </form>
      <Note>{t("keeping.explained")}</Note>
    </Panel>
  );
}
