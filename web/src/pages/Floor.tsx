// The shop floor: a card a machine, dense enough for sixty and readable from across the shop.
import { memo, useMemo, useState } from "react";
import { useTranslation } from "react-i18next";
import type { Live, MachineState } from "../api/types";
import { grouped, percent, whole } from "../format/number";
import { duration } from "../format/time";
import { inLanguage } from "../i18n";
import { useMachine, useMonotonic, useShop, type Seen } from "../live/hooks";
import { countStates, ageMs, shownState } from "../live/store";
import { link } from "../live/socket";
import { address, swap, useRoute } from "../shell/router";
import { useMay } from "../shell/session";
import { Icon, StateIcon } from "../ui/icons";
import { AgeText, Progress } from "../ui/parts";
import { AddMachine } from "./AddMachine";
import { Button } from "../ui/parts";

// In the order a person should look at them.
const stateOrder: MachineState[] = ["emergency_stop", "alarm", "hold", "stopped", "running", "setup", "idle", "off", "unknown"];

export function Floor({ wall }: { wall: boolean }) {
  const { t } = useTranslation();
  const route = useRoute();
  const administrator = useMay("administrator");
  const [adding, setAdding] = useState(false);
  const filter = route.search.get("state") as MachineState | null;
  const byUrgency = route.search.get("order") === "urgency";
  const machines = useShop((shop) => shop.machines);
  const linkState = useShop((shop) => shop.link);
  const now = useMonotonic(1000);

  const shop = link.state;
  const counts = countStates(shop, performance.now());
  const ids = useMemo(() => {
    const state = (live: Live) => shownState(live, ageMs(live, link.state.clock, performance.now()));
    const chosen = [...machines.values()].filter((live) => !filter || state(live) === filter);
    chosen.sort((a, b) => a.name.localeCompare(b.name, undefined, { numeric: true }));
    if (byUrgency) chosen.sort((a, b) => stateOrder.indexOf(state(a)) - stateOrder.indexOf(state(b)));
    return chosen.map((live) => live.machine);
    // `now`: ages move machines between states without any message.
    // eslint-disable-next-line react-hooks/exhaustive-deps
  }, [machines, filter, byUrgency, now]);

  const show = (change: Record<string, string | null>) => swap(address(["floor"],
    { state: filter, order: byUrgency ? "urgency" : null, wall: wall ? "1" : null, ...change }));
  const density = machines.size <= 12 ? "roomy" : machines.size <= 30 ? "medium" : "compact";

  return (
    <div className="floor" data-page="floor">
      <div className="floor-bar">
        <h1>{t("floor.title")}</h1>
        <div className="state-filter" role="group" aria-label={t("floor.filter")}>
          <button type="button" aria-pressed={!filter} onClick={() => show({ state: null })}>{t("floor.all")}<b>{machines.size}</b></button>
          {stateOrder.filter((state) => counts.has(state) || state === filter).map((state) => (
            <button key={state} type="button" className={`state-${state}`} aria-pressed={filter === state}
              onClick={() => show({ state: filter === state ? null : state })}>
              <StateIcon state={state} size={13} />{t(`state.${state}`)}<b>{counts.get(state) ?? 0}</b>
            </button>
          ))}
        </div>
        <div className="floor-tools">
          <Button small kind="quiet" aria-pressed={byUrgency} onClick={() => show({ order: byUrgency ? null : "urgency" })}>{t("floor.by_urgency")}</Button>
          <Button small kind="quiet" icon="wall" aria-pressed={wall} onClick={() => show({ wall: wall ? null : "1" })}>{t(wall ? "floor.wall_off" : "floor.wall")}</Button>
          {administrator && !wall && <Button small icon="plus" onClick={() => setAdding(true)}>{t("floor.add")}</Button>}
        </div>
      </div>
      {machines.size === 0 && (
        <div className="empty">{linkState === "open" ? t("floor.none") : t("common.loading")}</div>
      )}
      <div className={`cards ${density}`}>
        {ids.map((id) => <Card key={id} id={id} />)}
      </div>
      {adding && <AddMachine onClose={() => setAdding(false)} />}
    </div>
  );
}

const Card = memo(function Card({ id }: { id: number }) {
  const { t } = useTranslation();
  const seen = useMachine(id);
  const { live, state, age, current } = seen;
  if (!live) return null;
  const alarm = live.alarms?.[0];
  return (
    <a className={`card state-${state}${current ? "" : " stale"}`} href={address(["machines", id])} data-machine={id} data-state={state}
      aria-label={`${live.name}: ${t(`state.${state}`)}`}>
      <div className="card-head">
        <span className="card-name">{live.name}</span>
        <span className="card-state"><StateIcon state={state} size={15} /><span>{t(`state.${state}`)}</span></span>
      </div>
      <div className="card-body">
        <div className="card-program">
          <span className="program-name" data-field="program">{live.program?.name ?? t("common.no_program")}</span>
          {live.program?.revision ? <span className="revision">r{live.program.revision}</span> : null}
          <span className="card-marks">
            {live.remote_armed && current && <span className="mark armed" title={t("machine.armed")}><Icon name="unlock" size={13} />{t("machine.armed_short")}</span>}
            {live.mode && <span className="mark">{t(`mode.${live.mode}`)}</span>}
          </span>
        </div>
        {alarm ? (
          <div className="card-alarm" data-field="alarm"><b>{alarm.code}</b><span>{inLanguage(alarm.text)}</span>
            {(live.alarms?.length ?? 0) > 1 && <em>+{(live.alarms?.length ?? 1) - 1}</em>}</div>
        ) : (
          <div className="card-block mono" data-field="block">{live.line ? <span className="line-number">{live.line}</span> : null}{live.block || " "}</div>
        )}
        <div className="card-progress">
          <Progress part={live.progress} label={t("machine.progress")} state={current ? state : "stale"} />
          <span className="num">{percent(live.progress)}</span>
        </div>
        <CardFigures seen={seen} />
      </div>
      <div className="card-foot">
        <Overrides live={live} />
        <AgeText ms={age} prefix />
      </div>
    </a>
  );
});

function CardFigures({ seen: { live } }: { seen: Seen }) {
  const { t } = useTranslation();
  if (!live) return null;
  const required = live.parts?.required ?? 0;
  return (
    <div className="card-figures">
      <div className="figure parts"><label>{t("machine.parts")}</label>
        <span className="num" data-field="parts">{live.parts ? grouped(live.parts.count) : "—"}{required > 0 && <small> / {grouped(required)}</small>}</span></div>
      <div className="figure"><label>{t("machine.cycle")}</label><span className="num">{duration(live.cycle_s)}</span></div>
      <div className="figure"><label>{t("machine.remaining")}</label><span className="num">{duration(live.remaining_s)}</span></div>
      <div className="figure"><label>{t("machine.last_cycle")}</label><span className="num">{duration(live.last_cycle_s)}</span></div>
    </div>
  );
}

function Overrides({ live }: { live: Live }) {
  const { t } = useTranslation();
  const all = [["F", live.overrides?.feed, "override.feed"], ["R", live.overrides?.rapid, "override.rapid"], ["S", live.overrides?.spindle, "override.spindle"]] as const;
  return (
    <span className="overrides" aria-label={t("override.title")}>
      {all.map(([letter, value, name]) => (
        <span key={letter} className={value !== undefined && value !== 100 ? "changed" : ""} title={t(name)}><i>{letter}</i>{whole(value)}%</span>
      ))}
    </span>
  );
}
