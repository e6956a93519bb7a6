// Sets of machine data that controls have punched and somebody has accepted: the values, and what changed since the set before.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { get, list } from "../../api/client";
import type { Machine } from "../../api/types";
import { moment } from "../../format/time";
import { useLoad } from "../../live/hooks";
import { Button, Dialog, ErrorNote, Note, Panel } from "../../ui/parts";
import type { Port, PunchedData, PunchedValues } from "./types";

export function MachineData({ ports }: { ports: Port[] }) {
  const { t } = useTranslation();
  const { value, error } = useLoad((signal) => list<PunchedData>("/punched-data?limit=200", signal), []);
  const { value: machines } = useLoad((signal) => list<Machine>("/machines", signal), []);
  const [shown, setShown] = useState<PunchedData | null>(null);
  const place = (row: PunchedData) => machines?.find((one) => one.id === row.machine)?.name ?? ports.find((one) => one.id === row.port)?.name ?? String(row.port);
  return (
    <Panel className="flush" name="machine-data" title={t("dnc.tab_data")}>
      <ErrorNote error={error} />
      {value?.length === 0 && <div className="empty small">{t("dnc.data_none")}</div>}
      <table className="table"><tbody>{value?.map((row) => (
        <tr key={row.id} data-punched={row.id}><td className="dim">{moment(row.punched)}</td><td>{place(row)}</td><td><b>{t(`dnc.what_${row.kind}`)}</b></td>
          <td className="num">{t("dnc.data_values", { count: row.entries })}</td><td>{row.by}</td>
          <td className="row-actions"><Button small data-action="look" onClick={() => setShown(row)}>{t("dnc.look")}</Button></td></tr>))}</tbody></table>
      {shown && <Values row={shown} title={`${place(shown)} · ${t(`dnc.what_${shown.kind}`)} · ${moment(shown.punched)}`} onClose={() => setShown(null)} />}
    </Panel>
  );
}

function Values({ row, title, onClose }: { row: PunchedData; title: string; onClose: () => void }) {
  const { t } = useTranslation();
  const { value, error } = useLoad((signal) => get<PunchedValues>(`/punched-data/${row.id}`, signal), [row.id]);
  return (
    <Dialog title={title} name="machine-data" wide onClose={onClose} actions={<Button onClick={onClose}>{t("common.close")}</Button>}>
      <ErrorNote error={error} />
      {value && value.against === null && <Note>{t("dnc.data_first")}</Note>}
      {value && value.against !== null && value.changes.length === 0 && <Note kind="good">{t("dnc.data_same")}</Note>}
      {value && value.changes.length > 0 && <><h3>{t("dnc.data_changes")}</h3>
        <table className="table data-changes"><thead><tr><th /><th>{t("dnc.data_before")}</th><th>{t("dnc.data_after")}</th></tr></thead>
          <tbody>{value.changes.map((one) => <tr key={one.item} data-change={one.item}><td className="mono">{one.item}</td><td className="mono num">{one.before ?? "–"}</td><td className="mono num"><b>{one.after ?? "–"}</b></td></tr>)}</tbody></table></>}
      {value && <><h3>{t("dnc.data_all")}</h3><div className="received-text"><table className="table"><tbody>{value.values.map((one) => <tr key={one.item}><td className="mono">{one.item}</td><td className="mono num">{one.value}</td></tr>)}</tbody></table></div></>}
    </Dialog>
  );
}
