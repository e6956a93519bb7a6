import { useEffect, useMemo, useRef, useState } from "react";
import { useTranslation } from "react-i18next";
import { ApiError, get, list } from "../../api/client";
import type { Backplot, Machine, Revision } from "../../api/types";
import { Listing } from "../../gcode/Listing";
import { Code } from "../../gcode/Code";
import { grouped, percent, unknownText } from "../../format/number";
import { ageOf, duration } from "../../format/time";
import { inLanguage } from "../../i18n";
import { useLoad, useMachine, useWantMachine, type Seen } from "../../live/hooks";
import { PathView } from "../../path/PathView";
import { loadBackplot, Trail } from "../../path/plot";
import { address } from "../../shell/router";
import { Icon, StateIcon } from "../../ui/icons";
import { AgeText, Button, ErrorNote, Panel, Progress, StateBadge } from "../../ui/parts";
import { Commands } from "./Commands";
import { Figures, ModalCodes, Overrides, PartsAndTimes, Positions } from "./Readouts";
import { MachineRecords } from "./Records";

export function MachinePage({ id }: { id: number }) {
  const { t } = useTranslation();
  useWantMachine(id);
  const seen = useMachine(id);
  const { value: machine, error, reload } = useLoad((signal) => get<Machine>(`/machines/${id}`, signal), [id]);
  const [elsewhere, setElsewhere] = useState(false);
  if (error instanceof ApiError && error.status === 404) return <div className="page"><div className="empty">{t("machine.missing")}</div></div>;
  const live = seen.live;
  const name = live?.name ?? machine?.name ?? "";
  return (
    <div className="machine" data-page="machine" data-state={seen.state}>
      <div className={`machine-head state-${seen.state}`}>
        <a className="button quiet bare" href={address(["floor"])} aria-label={t("machine.back")}><Icon name="back" /></a>
        <div className="machine-title"><h1>{name}</h1><span>{live?.profile ?? machine?.profile}</span></div>
        <StateBadge state={seen.state} large />
        <span className="machine-marks">
          {live?.mode && <span className="mark">{t(`mode.${live.mode}`)}</span>}
          {seen.current && <span className={`mark ${live?.remote_armed ? "armed" : ""}`} data-field="armed" data-armed={Boolean(live?.remote_armed)}
            title={t(live?.remote_armed ? "machine.armed" : "machine.not_armed")}>
            <Icon name={live?.remote_armed ? "unlock" : "lock"} size={13} />{t(live?.remote_armed ? "machine.armed_short" : "machine.not_armed_short")}</span>}
          <AgeText ms={seen.age} prefix />
        </span>
        <Commands id={id} name={name} seen={seen} />
      </div>
      <ErrorNote error={error} />
      {live && !seen.current && <StaleNote seen={seen} />}
      {live?.alarms && live.alarms.length > 0 && (
        <div className="alarm-strip" role="alert" data-field="alarms">
          {live.alarms.map((alarm) => (
            <div key={alarm.id}><StateIcon state="alarm" size={18} /><b className="mono">{alarm.code}</b><span>{inLanguage(alarm.text)}</span>
              {alarm.line ? <em className="mono">{alarm.program} : {alarm.line}</em> : null}</div>))}
        </div>
      )}
      <div className={`machine-grid${seen.current ? "" : " stale"}`}>
        <Positions live={live} />
        <ToolPath id={id} seen={seen} elsewhere={elsewhere} />
        <RunningProgram seen={seen} elsewhere={elsewhere} onElsewhere={setElsewhere} />
        <Panel className="area-readouts" name="readouts"><Figures live={live} /><Overrides id={id} live={live} current={seen.current} /></Panel>
        <Panel className="area-modal" title={t("machine.modal")} name="modal"><ModalCodes live={live} /></Panel>
        <PartsAndTimes id={id} live={live} current={seen.current} />
      </div>
      <MachineRecords id={id} seen={seen} machine={machine} onChanged={reload} />
    </div>
  );
}

function StaleNote({ seen }: { seen: Seen }) {
  const { t } = useTranslation();
  if (seen.age === null) return <div className="stale-note" role="status"><StateIcon state="unknown" />{t("machine.never")}</div>;
  const age = ageOf(seen.age);
  return <div className="stale-note" role="status"><StateIcon state="unknown" />{t("machine.stale", { age: t(`age.${age.unit}`, { value: age.value }) })}</div>;
}

function useTrail(seen: Seen): { trail: Trail; version: number } {
  const trail = useRef(new Trail()).current;
  const { live, current } = seen;
  const program = live?.program?.name;
  useEffect(() => { trail.points = []; }, [program, trail]);
  useEffect(() => {
    if (!live || !current) return;
    const now = live.absolute ?? [];
    if (live.state === "running" || live.state === "hold") trail.add([...(live.trail ?? []), now], live.cycle_s);
  }, [live, current, trail]);
  // The effect above runs after this drawing; the next message shows it, 200 ms later at most.
  return { trail, version: trail.version };
}

function ToolPath({ id, seen, elsewhere }: { id: number; seen: Seen; elsewhere: boolean }) {
  const { t } = useTranslation();
  const { live } = seen;
  const program = live?.program;
  const { trail, version } = useTrail(seen);
  const known = Boolean(program?.id && program.revision);
  const { value: plot } = useLoad<Backplot | null>(async (signal) => {
    if (!program?.id || !program.revision) return null;
    return loadBackplot(program.id, program.revision, id, signal).catch(() => null);
  }, [program?.id, program?.revision, id]);
  const axes = useMemo(() => live?.axes ?? [], [live?.axes?.join()]); // eslint-disable-line react-hooks/exhaustive-deps
  return (
    <Panel className="area-path" title={t("machine.path")} name="path" extra={!known && <span className="dim">{t("machine.path_none")}</span>}>
      {axes.length > 0 && <PathView axes={axes} plot={plot ?? null} trail={trail} trailVersion={version} tool={live?.absolute ?? null} line={elsewhere ? null : live?.line ?? null} />}
    </Panel>
  );
}

function RunningProgram({ seen, elsewhere, onElsewhere }: { seen: Seen; elsewhere: boolean; onElsewhere: (elsewhere: boolean) => void }) {
  const { t } = useTranslation();
  const { live } = seen;
  const program = live?.program;
  const [follow, setFollow] = useState(true);
  const { value: revision } = useLoad<Revision | null>(async (signal) => {
    if (!program?.id || !program.revision) return null;
    return (await list<Revision>(`/programs/${program.id}/revisions`, signal)).find((one) => one.number === program.revision) ?? null;
  }, [program?.id, program?.revision]);
  return (
    <Panel className="area-program" name="program" title={<span className="program-title">
      <b data-field="program">{program?.name ?? t("common.no_program")}</b>
      {program?.revision ? <a href={address(["programs", program.id ?? 0], { rev: program.revision })}>{t("programs.revision_n", { number: program.revision })}</a> : null}
      {program?.released === true && <span className="chip good">{t("programs.released")}</span>}
    </span>} extra={revision && <Button small kind="quiet" aria-pressed={follow} onClick={() => setFollow(!follow)}>{t("machine.follow")}</Button>}>
      <div className="running-block mono" data-field="block"><span className="line-number">{live?.line ?? unknownText}</span><code><Code text={live?.block ?? ""} /></code>{elsewhere && revision && <span className="chip info">{t("machine.subprogram")}</span>}</div>
      <div className="running-progress"><Progress part={live?.progress} label={t("machine.progress")} state={seen.current ? seen.state : "stale"} />
        <span className="num" data-field="progress">{percent(live?.progress, 1)}</span><span className="num dim">{t("machine.remaining")} {duration(live?.remaining_s)}</span></div>
      {live?.drip && <div className="running-progress drip"><Progress part={live.drip.total > 0 ? live.drip.bytes / live.drip.total : null} label={t("machine.drip")} />
        <span className="num">{t("machine.drip")} {live.drip.total > 0 ? percent(live.drip.bytes / live.drip.total, 1) : grouped(live.drip.bytes)}</span></div>}
      {revision && program?.id
        ? <Listing program={program.id} revision={revision.number} total={revision.lines} line={live?.line} block={live?.block} onElsewhere={onElsewhere} follow={follow && !elsewhere} onUnfollow={() => setFollow(false)} label={t("machine.listing")} />
        : <div className="empty small">{t(program ? "machine.listing_unknown" : "machine.listing_none")}</div>}
    </Panel>
  );
}
