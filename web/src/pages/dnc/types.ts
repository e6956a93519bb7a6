// Ports and what goes over them, as the server says it (server/api/routes/ports.cpp).
export interface PortTransfer {
  id: number; port: number; kind: "send" | "drip" | "receive" | "answer"; state: string; program: number | null; revision: number | null;
  name: string; sha256: string | null; from_line: number; header: string | null; bytes: number; total: number | null; wire_sha256: string | null;
  reason: string | null; detail: string | null; by: string; created: string; started: string | null; ended: string | null;
  figures: { stops?: number; most_after_stop?: number; held_ms?: number; starved_ms?: number; blocks?: number };
}
export interface PortSettings { protocol: string; line: string; code: string; [name: string]: unknown }
export interface Signals { rts: boolean; dtr: boolean; cts: boolean; dsr: boolean; dcd: boolean; ring: boolean }
export interface Port {
  id: number; kind: "line" | "agent"; name: string; machine: number | null; address: string; settings: PortSettings; listens: boolean; folder: string;
  name_rule: string; rules: { pattern: string; action: string; name: string }[];
  state: "closed" | "opening" | "listening" | "busy" | "failed"; reason: string | null; detail: string | null;
  signals: Signals | null; transfer: PortTransfer | null; queue: PortTransfer[];
  measured: {
    window: number; stop_margin: number; transfers: number; stops: number; most_after_stop: number; longest_stop_us: number;
    longest_hold_ms: number; starved_ms: number; sending_ms: number; round_trip_us: number | null;
  };
}
export interface Protocol { name: string; text: { en: string; zh: string }; source: string; settings: PortSettings }
export interface Received {
  id: number; port: number; machine: number | null; kind: string; name: string; comment: string; closed: boolean; folder: string; program: number | null;
  against_revision: number | null; classes: string[]; state: string; at: string; decided_by: string | null;
}
export interface PunchedOutcome { written: number; differ: number; same: number; without_place: number; request: number | null; request_state: string | null; request_reason: string | null }
export interface MonitorEntry { sequence: number; at: string; kind: "in" | "out" | "signals" | "fault" | "note"; text: string; hex: string | null }
export interface Plan { id: number; port: number; program: number; revision: number; name: string; drip: boolean; from_line: number; at: string; state: string; reason: string | null; transfer: number | null; by: string; ended: string | null }
export interface CensusEntry {
  machine: number | null; machine_name: string | null; port: number | null; port_name: string | null; name: string; sha256: string;
  program: number | null; revision: number | null; released: number | null; proof: "reported" | "sent" | "punched";
  state: "released" | "older" | "changed" | "unknown"; classes: string[]; since: string | null; proven: string | null;
}
export interface PunchedData { id: number; machine: number | null; port: number; kind: string; name: string; entries: number; by: string; punched: string; accepted: string }
export interface PunchedValues extends PunchedData { values: { item: string; value: string }[]; against: number | null; changes: { item: string; before: string | null; after: string | null }[] }
export const isSending = (transfer: PortTransfer) => transfer.kind !== "receive";
