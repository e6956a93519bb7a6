// Ports and what goes over them, as the server says it (server/api/routes/ports.cpp).
export interface PortTransfer {
  id: number; port: number; kind: "send" | "drip" | "receive" | "answer"; state: string; program: number | null; revision: number | null;
  name: string; from_line: number; header: string | null; bytes: number; total: number | null; wire_sha256: string | null;
  reason: string | null; detail: string | null; by: string; created: string; started: string | null; ended: string | null;
  figures: { stops?: number; most_after_stop?: number; held_ms?: number; starved_ms?: number; blocks?: number };
}
export interface PortSettings { protocol: string; line: string; code: string; [name: string]: unknown }
export interface Signals { rts: boolean; dtr: boolean; cts: boolean; dsr: boolean; dcd: boolean; ring: boolean }
export interface Port {
  id: number; name: string; machine: number | null; address: string; settings: PortSettings; listens: boolean; folder: string;
  name_rule: string; rules: { pattern: string; action: string; name: string }[];
  state: "closed" | "opening" | "listening" | "busy" | "failed"; reason: string | null; detail: string | null;
  signals: Signals | null; transfer: PortTransfer | null; queue: PortTransfer[];
  measured: { window: number; most_after_stop: number; stops: number; starved_ms: number; longest_hold_ms: number };
}
export interface Protocol { name: string; text: { en: string; zh: string }; source: string; settings: PortSettings }
export interface Received {
  id: number; port: number; kind: string; name: string; comment: string; closed: boolean; folder: string; program: number | null;
  against_revision: number | null; classes: string[]; state: string; at: string; decided_by: string | null;
}
export interface MonitorEntry { sequence: number; at: string; kind: "in" | "out" | "signals" | "fault" | "note"; text: string; hex: string | null }
export const isSending = (transfer: PortTransfer) => transfer.kind !== "receive";
