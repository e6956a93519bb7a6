import { unknownText } from "./number";

/// 75.4 -> "1:15"; 3725 -> "1:02:05".
export function duration(seconds: number | null | undefined): string {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds) || seconds < 0) return unknownText;
  const total = Math.floor(seconds);
  const h = Math.floor(total / 3600);
  const m = Math.floor((total % 3600) / 60);
  const s = String(total % 60).padStart(2, "0");
  return h > 0 ? `${h}:${String(m).padStart(2, "0")}:${s}` : `${m}:${s}`;
}

/// 5400 -> "1.5 h", 95 -> "1.6 min": for sums, where seconds do not matter.
export function hours(seconds: number): string {
  if (seconds >= 3600) return `${(seconds / 3600).toFixed(seconds < 36_000 ? 2 : 1)} h`;
  return seconds >= 60 ? `${(seconds / 60).toFixed(1)} min` : `${Math.round(seconds)} s`;
}

export type Age = { unit: "ms" | "s" | "min" | "h" | "d"; value: number };

/// One figure and one unit: what a person can judge at a glance.
export function ageOf(ms: number): Age {
  if (ms < 1_000) return { unit: "ms", value: Math.round(ms / 100) * 100 };
  if (ms < 60_000) return { unit: "s", value: Math.floor(ms / 1_000) };
  if (ms < 3_600_000) return { unit: "min", value: Math.floor(ms / 60_000) };
  if (ms < 86_400_000) return { unit: "h", value: Math.floor(ms / 3_600_000) };
  return { unit: "d", value: Math.floor(ms / 86_400_000) };
}

const two = (n: number) => String(n).padStart(2, "0");

/// Local time of the person who looks, sortable by eye: 2026-01-31 14:05:09.
export function moment(iso: string | null | undefined): string {
  if (!iso) return unknownText;
  const t = new Date(iso);
  if (Number.isNaN(t.getTime())) return unknownText;
  return `${t.getFullYear()}-${two(t.getMonth() + 1)}-${two(t.getDate())} ${two(t.getHours())}:${two(t.getMinutes())}:${two(t.getSeconds())}`;
}

/// The time of day with milliseconds, for what happens many times a second.
export function clockTime(iso: string): string {
  const at = new Date(iso);
  return `${at.toLocaleTimeString("en-GB")}.${String(at.getMilliseconds()).padStart(3, "0")}`;
}
