// The shapes of server/api/README.md. What the server does not know is null.

export interface Localised { en: string; zh: string }

export type MachineState =
  | "running" | "hold" | "stopped" | "idle" | "alarm" | "emergency_stop" | "setup" | "off" | "unknown";

export type Role = "viewer" | "operator" | "programmer" | "setter" | "administrator";
export const roles: readonly Role[] = ["viewer", "operator", "programmer", "setter", "administrator"];

export interface Session { user: string; name: string; role: Role; language: string | null; must_change_password?: boolean; look_only?: boolean; machine_roles?: Record<string, Role> }

export interface User {
  id: number; user: string; name: string; role: Role; language: string | null; disabled: boolean; last_sign_in: string | null;
}

export interface ActiveAlarm {
  id: number; code: string; text: Localised; since: string; line: number | null; program: string | null;
}

export interface Drip { transfer: number; bytes: number; total: number; buffered: number }

export interface Live {
  machine: number; name: string; profile: string; connected: boolean;
  received: string | null; age_ms: number | null;
  state: MachineState; mode: string | null; remote_armed: boolean | null;
  program: { name: string; id: number | null; revision: number | null; sha256: string | null; released: boolean | null } | null;
  line: number | null; sequence: number | null; block: string | null; progress: number | null;
  cycle_s: number | null; last_cycle_s: number | null; remaining_s: number | null;
  parts: { count: number; required: number; total: number } | null;
  run_time_s: number | null; cutting_time_s: number | null;
  axes: string[] | null; absolute: number[] | null; relative: number[] | null;
  machine_position: number[] | null; distance_to_go: number[] | null;
  feed: { actual_mm_min: number | null; commanded: number | null } | null;
  spindle: { actual_rpm: number | null; commanded_rpm: number | null } | null;
  tool: number | null; offset: number | null; modal: string[] | null;
  overrides: { feed: number; rapid: number; spindle: number } | null;
  switches: Record<string, boolean> | null;
  alarms: ActiveAlarm[] | null;
  trail?: number[][] | null;
  drip?: Drip | null;
}

export interface AxisLimits { name: string; min_mm?: number | null; max_mm?: number | null; diameter?: boolean; designation?: string }

export interface Machine {
  id: number; name: string; profile: string; live?: Live | null;
  toml?: string | null; axes?: AxisLimits[] | null; enrolment_token?: string; [more: string]: unknown;
}

export interface Profile { id?: string; profile?: string; name?: string | Localised; kind?: string; [more: string]: unknown }

/// One machine in one stretch of time, with what was counted.
export interface OeeRow {
  machine: number; from: string; to: string; day: string | null; shift: string | null;
  availability: number | null; performance: number | null; quality: number | null; oee: number | null;
  scheduled_s: number; planned_s: number; planned_stop_s: number; unknown_s: number; unexplained_s: number;
  states: Partial<Record<MachineState, number>>; reasons: { reason: number; s: number }[];
  parts: number; rejects: number; ideal_s: number; parts_without_ideal: number;
}
export interface Shift { name: string; days: number[]; start: string; end: string }
export interface Calendar { time_zone: string; shifts: Shift[] }
export interface AlarmFigure { code: string; text: Localised; count: number; active_s: number; machines: number; last: string }
export interface DowntimeReason { id: number; name: Localised; planned: boolean }
export interface Stop {
  from: string; to: string; state: MachineState; open: boolean;
  note: { id: number; reason: number | null; note: string; by: string; at: string } | null;
}

export interface Resident {
  name: string; sha256: string | null; bytes: number | null; since: string | null; selected?: boolean;
  program_id?: number | null; program?: number | null; revision: number | null; stale: boolean | null; released?: boolean | null;
}

export interface Revision {
  number: number; sha256: string; bytes: number; lines: number; encoding: string | null; line_ends?: string | null; nul_bytes?: number; by: string; at: string;
  note: string; origin: string; released: { by: string; at: string; why: string } | null;
}

export interface Program { id: number; folder: string; name: string; created?: string; newest: Revision | null; released: Revision | null }

export interface Uploaded {
  program: Program; revision: Revision; created: boolean; duplicate_of: { program: number; revision: number } | null;
  findings_encoding?: { encoding: string; line_ends: string; nul_bytes: number; longest_line: number; has_percent: boolean };
}

export interface Finding { line: number; column: number; code: string; text: Localised }

export interface CheckResult {
  ok: boolean; findings: Finding[]; time_s: number | null; cutting_s: number | null; length_mm: number | null;
  bounds?: unknown; tools?: number[] | null; machine?: number; timed?: boolean; blocks?: number; at?: string | null;
}

export type DiffClass = "comment" | "feed_speed" | "offset" | "geometry" | "structure";
export interface DiffRow {
  kind: "same" | "changed" | "added" | "removed" | "skipped"; skipped?: number; left: string | null; right: string | null;
  left_line: number | null; right_line: number | null; class: DiffClass | null;
}
export interface Diff { rows: DiffRow[]; classes: DiffClass[]; changed: number; added: number; removed: number; truncated: boolean; coarse: boolean }

export interface Move { k: "r" | "f" | "a" | "t"; l: number; p: number[] }
/// Points in work coordinates, mm; X of a lathe as a radius (operation/backplot.hpp).
export interface Backplot { axes: string[]; start?: number[]; moves: Move[]; truncated: boolean }

export interface Transfer {
  id: number; machine: number; program: number | null; revision: number | null; kind: "put" | "drip"; state: string;
  bytes: number; total: number; rate?: number | null; reason: string | null; sha256?: string | null;
  started: string | null; ended: string | null; [more: string]: unknown;
}

export interface Distribution { id: number; program: number; revision: number; transfers: Transfer[] }

export interface AlarmRecord {
  id: number; machine: number; code: string; text: Localised; since?: string; raised?: string; at?: string;
  cleared: string | null; line: number | null; program: string | null; block?: string | null;
}

export interface List<T> { items: T[]; next: string | null }
