// What lies in every machine, since when, and how that is known. Nothing is taken for current only because it was sent once.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { list } from "../../api/client";
import type { DiffClass } from "../../api/types";
import { moment } from "../../format/time";
import { useLoad } from "../../live/hooks";
import { ErrorNote, Panel } from "../../ui/parts";
import { classTone } from "../programs/Difference";
import type { CensusEntry } from "./types";

const tone: Record<CensusEntry["state"], string> = { released: "good", older: "warn", changed: "bad", unknown: "warn" };

export function Census() {
  const { t } = useTranslation();
  const { value, error } = useLoad((signal) => list<CensusEntry>("/census", signal), []);
  const [odd, setOdd] = useState(false);
  const shown = (value ?? []).filter((one) => !odd || one.state !== "released");
  return (
    <Panel className="flush" name="census" title={t("dnc.tab_census")}
      extra={<label className="check"><input type="checkbox" checked={odd} data-field="odd" onChange={(event) => setOdd(event.target.checked)} />{t("dnc.census_odd")}</label>}>
      <ErrorNote error={error} />
      {value && shown.length === 0 && <div className="empty small">{t("dnc.census_none")}</div>}
      {shown.length > 0 && <table className="table"><thead><tr><th>{t("dnc.field_machine")}</th><th>{t("dnc.send_program")}</th><th>{t("dnc.census_lies")}</th><th>{t("dnc.census_released")}</th><th>{t("dnc.census_state")}</th><th>{t("dnc.census_proof")}</th><th>SHA-256</th></tr></thead>
        <tbody>{shown.map((one) => (
          <tr key={`${one.machine ?? ""}/${one.port ?? ""}/${one.name}`} data-resident={one.name} data-state={one.state}>
            <td>{one.machine_name ?? one.port_name}{one.machine_name && one.port_name ? <span className="dim"> · {one.port_name}</span> : null}</td><td><b>{one.name}</b></td>
            <td>{one.revision ? t("programs.revision_n", { number: one.revision }) : "–"}</td><td>{one.released ? t("programs.revision_n", { number: one.released }) : "–"}</td>
            <td><span className={`chip ${tone[one.state]}`}>{t(`dnc.census_${one.state}`)}</span> {one.classes.map((name) => <span key={name} className={`chip ${classTone[name as DiffClass] ?? ""}`}>{t(`class.${name}`)}</span>)}</td>
            <td>{t(`dnc.proof_${one.proof}`)} <span className="dim">{moment(one.proven)}</span></td><td className="mono dim" title={one.sha256}>{one.sha256.slice(0, 10)}</td></tr>))}</tbody></table>}
    </Panel>
  );
}
