// What a machine did and when, a line a day; and how many parts came of it, beside what could have come.
import { useTranslation } from "react-i18next";
import { list, query } from "../../api/client";
import type { OeeRow } from "../../api/types";
import { unknownText } from "../../format/number";
import { hours, moment } from "../../format/time";
import { useLoad } from "../../live/hooks";
import { CsvLink, ErrorNote, Panel } from "../../ui/parts";
import { daysOf, targetParts, type StateInterval } from "./timeline";

const clock = [0, 6, 12, 18, 24];

export function Timeline({ machine, span }: { machine: number; span: { from: string; to: string } }) {
  const { t } = useTranslation();
  const path = `/machines/${machine}/states${query(span)}`;
  const { value, error } = useLoad((signal) => list<StateInterval>(path, signal), [path]);
  const days = daysOf(value ?? [], Date.parse(span.from), Date.parse(span.to));
  return (
    <Panel name="timeline" title={t("times.timeline")} extra={<CsvLink path={path} />}>
      <ErrorNote error={error} />
      <div className="timeline">
        <span /><div className="timeline-clock" aria-hidden>{clock.map((hour) => <i key={hour} style={{ left: `${(hour / 24) * 100}%` }}>{hour}</i>)}</div>
        {days.map((day) => [
          <span key={day.from} className="num">{moment(new Date(day.from).toISOString()).slice(5, 10)}</span>,
          <div key={`${day.from} states`} className="timeline-day" data-day={day.from}>{day.pieces.map((piece) => (
            <span key={piece.from} className={`state-${piece.state}`} style={{ left: `${piece.left * 100}%`, width: `${piece.width * 100}%` }}
              title={`${t(`state.${piece.state}`)} ${moment(new Date(piece.from).toISOString()).slice(11, 16)}–${moment(new Date(piece.to).toISOString()).slice(11, 16)} · ${hours((piece.to - piece.from) / 1000)}`} />))}</div>])}
      </div>
    </Panel>
  );
}

/// The bar is what was made, the mark what the planned time would have given.
export function PartsAgainstTarget({ row, most }: { row: OeeRow; most: number }) {
  const { t } = useTranslation();
  const target = targetParts(row), good = row.parts - row.rejects, share = (parts: number) => `${(parts / Math.max(1, most)) * 100}%`;
  return (
    <div className="parts-target" role="img" title={t("times.target_explained")} aria-label={t("times.parts_of_target", { parts: good, target: target ?? unknownText })}>
      <span className="made" style={{ width: share(good) }} />{row.rejects > 0 && <span className="rejected" style={{ left: share(good), width: share(row.rejects) }} />}
      {target !== null && <i className="target" style={{ left: share(target) }} />}
    </div>
  );
}
