// The states of a machine as they followed each other, cut into the days of the person who looks. No DOM: tested by itself.
import type { MachineState } from "../../api/types";

export interface StateInterval { state: MachineState; from: string; to: string | null }
export interface Piece { state: MachineState; from: number; to: number; left: number; width: number }   // left, width: share of the day
export interface Day { from: number; to: number; pieces: Piece[] }

/// Midnight to midnight: a day of a changed clock has 23 or 25 hours. The last day is whole, too; what is to come stays empty.
export function daysOf(intervals: StateInterval[], from: number, to: number): Day[] {
  const days: Day[] = [];
  for (let at = midnight(from); at < to; at = midnight(at, 1)) days.push({ from: at, to: midnight(at, 1), pieces: [] });
  for (const one of intervals) {
    const begin = Math.max(Date.parse(one.from), from), end = Math.min(one.to === null ? to : Date.parse(one.to), to);
    for (const day of days) {
      const a = Math.max(begin, day.from), b = Math.min(end, day.to), whole = day.to - day.from;
      if (b <= a) continue;
      const last = day.pieces[day.pieces.length - 1];
      // Nothing is lost to the eye by joining what follows at once in the same state.
      if (last && last.state === one.state && a - last.to <= 1_000) { last.to = b; last.width = (b - last.from) / whole; }
      else day.pieces.push({ state: one.state, from: a, to: b, left: (a - day.from) / whole, width: (b - a) / whole });
    }
  }
  return days;
}

function midnight(at: number, later = 0): number {
  const day = new Date(at);
  return new Date(day.getFullYear(), day.getMonth(), day.getDate() + later).getTime();
}

/// Parts that the planned time would have given at the time the checks predict for each; null: no check predicted one.
export function targetParts(row: { parts: number; parts_without_ideal: number; ideal_s: number; planned_s: number }): number | null {
  const timed = row.parts - row.parts_without_ideal;
  return timed > 0 && row.ideal_s > 0 ? Math.floor((row.planned_s * timed) / row.ideal_s) : null;
}
