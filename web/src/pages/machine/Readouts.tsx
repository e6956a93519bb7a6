import { useState } from "react";
import { useTranslation } from "react-i18next";
import type { Live } from "../../api/types";
import { fixed, grouped, position, unknownText, whole } from "../../format/number";
import { duration } from "../../format/time";
import { isLathe } from "../../path/plot";
import { useMay } from "../../shell/session";
import { Button, Dialog, Field, Panel, Progress, Tabs, useAction } from "../../ui/parts";
import { useCommand } from "./Commands";

type Page = "absolute" | "relative" | "machine" | "distance";
const sources: Record<Page, (live: Live) => number[] | null> = {
  absolute: (live) => live.absolute, relative: (live) => live.relative, machine: (live) => live.machine_position, distance: (live) => live.distance_to_go,
};

/// As on the control: one page large, the others small below it.
export function Positions({ live }: { live: Live | undefined }) {
  const { t } = useTranslation();
  const [chosen, setChosen] = useState<Page>("absolute");
  const axes = live?.axes ?? [];
  const turning = isLathe(axes);
  const pages = Object.keys(sources) as Page[];
  return (
    <Panel className="area-positions" name="positions">
      <Tabs label={t("machine.positions")} value={chosen} onChange={setChosen} options={pages.map((value) => ({ value, text: t(`machine.${value}`) }))} />
      <div className="position-big mono" data-positions={chosen}>
        {axes.map((axis, i) => (
          <div key={axis}><b>{axis}{turning && axis === "X" && chosen !== "machine" && <sup>⌀</sup>}</b><span data-axis={axis}>{live ? position(sources[chosen](live)?.[i]) : unknownText}</span></div>))}
        {axes.length === 0 && <div className="dim">{unknownText}</div>}
      </div>
      <table className="position-small mono"><tbody>
        {pages.filter((page) => page !== chosen).map((page) => (
          <tr key={page}><th>{t(`machine.${page}`)}</th>{axes.map((axis, i) => <td key={axis}><i>{axis}</i>{live ? position(sources[page](live)?.[i]) : unknownText}</td>)}</tr>))}
      </tbody></table>
    </Panel>
  );
}

export function Figures({ live }: { live: Live | undefined }) {
  const { t } = useTranslation();
  return (
    <div className="figures">
      <div><label>F · {t("machine.feed")}</label><b className="mono">{fixed(live?.feed?.actual_mm_min, 1)}</b><small>mm/min</small></div>
      <div><label>S · {t("machine.spindle")}</label><b className="mono">{whole(live?.spindle?.actual_rpm)}</b><small>/ {whole(live?.spindle?.commanded_rpm)} rpm</small></div>
      <div><label>T · {t("machine.tool")}</label><b className="mono">{whole(live?.tool)}</b><small>{t("machine.offset")} {whole(live?.offset)}</small></div>
    </div>
  );
}

// Dry run and machine lock belong to the person who stands at the machine.
const remoteSwitches = ["single_block", "optional_stop", "block_skip"];
const limits = { feed: [0, 150], rapid: [0, 100], spindle: [50, 120] } as const;

export function Overrides({ id, live, current }: { id: number; live: Live | undefined; current: boolean }) {
  const { t } = useTranslation();
  const may = useMay("operator") && current;
  const command = useCommand(id, live?.name ?? "");
  const { busy, run } = useAction();
  const switches = Object.entries(live?.switches ?? {});
  return (
    <>
      <div className="override-rows">
        {(Object.keys(limits) as (keyof typeof limits)[]).map((which) => {
          const value = live?.overrides?.[which];
          const [least, most] = limits[which];
          const step = (by: number) => run(async () => { await command(`set_${which}_override`, Math.min(most, Math.max(least, (value ?? 100) + by)) / 100, true); });
          return (
            <div key={which} className={`override-row${value !== undefined && value !== 100 ? " changed" : ""}`} data-override={which}>
              <label>{t(`override.${which}`)}</label>
              <Progress part={value === undefined ? null : value / 150} label={t(`override.${which}`)} />
              <b className="num">{value === undefined ? unknownText : `${whole(value)} %`}</b>
              <Button small kind="quiet" disabled={!may} busy={busy} aria-label={`${t(`override.${which}`)} −10`} onClick={() => step(-10)}>−</Button>
              <Button small kind="quiet" disabled={!may} busy={busy} aria-label={`${t(`override.${which}`)} +10`} onClick={() => step(10)}>+</Button>
            </div>);
        })}
      </div>
      {switches.length > 0 && <div className="switches" aria-label={t("machine.switches")}>
        {switches.map(([name, on]) => (remoteSwitches.includes(name)
          ? <button key={name} type="button" className={`switch ${on ? "on" : ""}`} aria-pressed={on} disabled={!may || busy} data-switch={name}
            onClick={() => run(async () => { await command(`set_${name}`, on ? 0 : 1, true); })}>{t(`switch.${name}`)}</button>
          : <span key={name} className={`switch ${on ? "on" : ""}`} title={t("machine.switch_local")}>{t(`switch.${name}`, { defaultValue: name })}</span>))}
      </div>}
    </>
  );
}

export function ModalCodes({ live }: { live: Live | undefined }) {
  if (!live?.modal || live.modal.length === 0) return <span className="dim">{unknownText}</span>;
  return <div className="modal-codes mono" data-field="modal">{live.modal.map((code) => <span key={code}>{code}</span>)}</div>;
}

export function PartsAndTimes({ id, live, current }: { id: number; live: Live | undefined; current: boolean }) {
  const { t } = useTranslation();
  const may = useMay("operator") && current;
  const command = useCommand(id, live?.name ?? "");
  const { busy, run } = useAction();
  const [wanted, setWanted] = useState<string | null>(null);
  const parts = live?.parts;
  return (
    <Panel className="area-parts" name="parts" title={t("machine.times")} extra={may && <Button small kind="quiet" icon="edit" aria-label={t("machine.required")} title={t("machine.required")} onClick={() => setWanted(String(parts?.required ?? 0))} />}>
      {wanted !== null && (
        <Dialog title={t("machine.required")} name="required" onClose={() => setWanted(null)} actions={<><Button onClick={() => setWanted(null)}>{t("common.cancel")}</Button><Button kind="primary" type="submit" form="required-form" busy={busy}>{t("common.save")}</Button></>}>
          <form id="required-form" onSubmit={(event) => { event.preventDefault(); const value = Math.round(Number(wanted)); setWanted(null); run(async () => { await command("set_parts_required", value, true); }); }}>
            <Field label={t("machine.required")}><input type="number" min={0} max={9_999_999} step={1} value={wanted} autoFocus onChange={(event) => setWanted(event.target.value)} required /></Field></form>
        </Dialog>)}
      <div className="parts-big"><b className="num" data-field="parts">{parts ? grouped(parts.count) : unknownText}</b>
        {parts && parts.required > 0 && <span className="num">/ {grouped(parts.required)}</span>}<small>{t("machine.parts_total")} <span className="num" data-field="parts-total">{parts ? grouped(parts.total) : unknownText}</span></small></div>
      <Progress part={parts && parts.required > 0 ? parts.count / parts.required : null} label={t("machine.parts")} state="running" />
      <dl className="facts times">
        <dt>{t("machine.cycle")}</dt><dd className="num">{duration(live?.cycle_s)}</dd>
        <dt>{t("machine.last_cycle")}</dt><dd className="num">{duration(live?.last_cycle_s)}</dd>
        <dt>{t("machine.run_time")}</dt><dd className="num">{duration(live?.run_time_s)}</dd>
        <dt>{t("machine.cutting_time")}</dt><dd className="num">{duration(live?.cutting_time_s)}</dd>
      </dl>
    </Panel>
  );
}
