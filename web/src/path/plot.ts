// What the tool-path views share: points in work coordinates, X of a lathe as a diameter until it is drawn.
import type { Backplot } from "../api/types";
import { get, query, settled } from "../api/client";

export interface Bounds { min: number[]; max: number[] }

export const isLathe = (axes: readonly string[]) => axes.includes("X") && axes.includes("Z") && !axes.includes("Y");

export function columns(axes: readonly string[], names: readonly string[]): number[] {
  return names.map((name) => axes.indexOf(name));
}

/// @param cutting only what cuts: the approach from the reference point would make a part tiny.
export function bounds(plot: Backplot, columnsOf: number[], cutting: boolean): Bounds | null {
  const min = columnsOf.map(() => Infinity);
  const max = columnsOf.map(() => -Infinity);
  plot.moves.forEach((move, i) => {
    if (cutting && move.k === "r") return;
    // A move cuts from where the one before it ended.
    for (const point of [plot.moves[i - 1]?.p, move.p]) {
      if (!point) continue;
      columnsOf.forEach((column, c) => {
        const value = point[column] ?? 0;
        min[c] = Math.min(min[c] ?? Infinity, value);
        max[c] = Math.max(max[c] ?? -Infinity, value);
      });
    }
  });
  return min.every(Number.isFinite) ? { min, max } : cutting ? bounds(plot, columnsOf, false) : null;
}

/// 1, 2 or 5 times a power of ten, so that about `count` steps fill the span.
export function niceStep(span: number, count: number): number {
  const raw = span / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(raw || 1));
  const factor = [1, 2, 5, 10].find((f) => f * power >= raw) ?? 10;
  return factor * power;
}

/// The path really travelled, as reported; starts anew with each cycle.
export class Trail {
  points: number[][] = [];
  version = 0;
  private cycle = 0;
  add(points: readonly number[][], cycleS: number | null): void {
    if (cycleS !== null && cycleS + 0.5 < this.cycle) this.points = [];
    this.cycle = cycleS ?? this.cycle;
    for (const point of points) {
      const last = this.points.at(-1);
      if (!last || point.some((value, i) => Math.abs(value - (last[i] ?? 0)) > 0.0005)) this.points.push(point);
    }
    if (this.points.length > 20_000) this.points = this.points.slice(-16_000);
    this.version += 1;
  }
}

export function cssColour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/// The server plots X of a lathe as the slide moves (radius); the rest of the application speaks in diameters, as the
/// position page does. Called once, where a plot comes in.
export function inDiameters(plot: Backplot): Backplot {
  const x = plot.axes.indexOf("X");
  if (!isLathe(plot.axes)) return plot;
  const widen = (p: number[]) => p.map((value, i) => (i % plot.axes.length === x ? value * 2 : value));
  return { ...plot, ...(plot.start ? { start: widen(plot.start) } : {}), moves: plot.moves.map((move) => ({ ...move, p: widen(move.p) })) };
}

/// A move may hold several points (the chords of an arc), one after the other: here every point becomes a move.
export function expand(plot: Backplot): Backplot {
  const n = plot.axes.length;
  if (n === 0) return plot;
  // Every move is drawn from the end of the one before it; where the first begins is said apart.
  const moves: Backplot["moves"] = plot.start?.length === n ? [{ k: "r", l: 0, p: plot.start }] : [];
  for (const move of plot.moves) {
    if (move.p.length <= n) { moves.push(move); continue; }
    for (let at = 0; at + n <= move.p.length; at += n) moves.push({ k: move.k, l: move.l, p: move.p.slice(at, at + n) });
  }
  return { ...plot, moves };
}

export async function loadBackplot(program: number, revision: number, machine: number | null, signal: AbortSignal): Promise<Backplot> {
  const answer = await get<Backplot>(`/programs/${program}/revisions/${revision}/backplot${query({ machine })}`, signal);
  return expand(inDiameters(await settled(answer, signal)));
}
