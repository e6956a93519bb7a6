// What the server last said about every machine, and how old it is. A value is only as good as its age: when the link
// is lost, or a machine has not been heard for `staleAfterMs`, its state is "unknown", whatever was said last.
import type { Live, MachineState, Transfer } from "../api/types";

export const staleAfterMs = 6_000;

export type LinkState = "connecting" | "open" | "lost";

/// Server time against this page's own monotonic clock, so that a wrong clock on a tablet makes nothing look fresh.
export interface ServerClock { serverMs: number; monotonicMs: number }

export interface Shop {
  link: LinkState;
  lostSince: number | null;                 // monotonic
  attempt: number;
  clock: ServerClock | null;
  machines: ReadonlyMap<number, Live>;
  transfers: ReadonlyMap<number, Transfer>;
  alarmsSeen: number;                       // grows with each alarm or clearing, so that lists know to ask again
  partsSeen: number;
  programsSeen: number;
  valuesSeen: ReadonlyMap<number, number>;  // machine → how often its values or requests have changed
}

export const emptyShop: Shop = {
  link: "connecting", lostSince: null, attempt: 0, clock: null,
  machines: new Map(), transfers: new Map(), alarmsSeen: 0, partsSeen: 0, programsSeen: 0, valuesSeen: new Map(),
};

export type ServerMessage =
  | { type: "snapshot"; machines: Live[]; now?: string; transfers?: Transfer[] }
  | { type: "live"; machine: number; live: Live }
  | { type: "tick"; now: string }
  | { type: "alarm" } | { type: "part" } | { type: "program" }
  | { type: "transfer"; transfer?: Transfer } & Partial<Transfer>
  | { type: "machine"; machine?: number; removed?: boolean; changed?: string };

export function receive(shop: Shop, message: ServerMessage, monotonicMs: number): Shop {
  switch (message.type) {
    case "snapshot":
      return {
        ...shop, link: "open", lostSince: null, attempt: 0,
        clock: message.now ? clockFrom(message.now, monotonicMs, null) : clockOf(message.machines, monotonicMs) ?? shop.clock,
        machines: new Map(message.machines.map((live) => [live.machine, live])),
      };
    case "live":
      return {
        ...shop, machines: new Map(shop.machines).set(message.machine, message.live),
        clock: shop.clock ?? clockOf([message.live], monotonicMs),
      };
    case "tick":
      return { ...shop, clock: clockFrom(message.now, monotonicMs, shop.clock) };
    case "transfer": {
      const transfer = message.transfer ?? (message as unknown as Transfer);
      return { ...shop, transfers: new Map(shop.transfers).set(transfer.id, transfer) };
    }
    case "alarm":
      return { ...shop, alarmsSeen: shop.alarmsSeen + 1 };
    case "part":
      return { ...shop, partsSeen: shop.partsSeen + 1 };
    case "program":
      return { ...shop, programsSeen: shop.programsSeen + 1 };
    case "machine":
      return message.changed === "values" && message.machine !== undefined
        ? { ...shop, valuesSeen: new Map(shop.valuesSeen).set(message.machine, (shop.valuesSeen.get(message.machine) ?? 0) + 1) } : shop;
    default:
      return shop;                          // newer servers may say more
  }
}

export function lost(shop: Shop, monotonicMs: number): Shop {
  return { ...shop, link: "lost", lostSince: shop.lostSince ?? monotonicMs, attempt: shop.attempt + 1 };
}

/// Before the first tick, the ages the server itself gave tell its time.
function clockOf(machines: Live[], monotonicMs: number): ServerClock | null {
  for (const live of machines) {
    if (live.received && live.age_ms !== null) return { serverMs: Date.parse(live.received) + live.age_ms, monotonicMs };
  }
  return null;
}

/// The newest tick gives the offset; one that was delayed on the way would make old values look younger, so of two that
/// disagree the later server time wins.
function clockFrom(now: string, monotonicMs: number, before: ServerClock | null): ServerClock | null {
  const serverMs = Date.parse(now);
  if (Number.isNaN(serverMs)) return before;
  if (before) {
    const expected = before.serverMs + (monotonicMs - before.monotonicMs);
    // A jump of more than a minute is a server whose clock was set: believe it.
    if (serverMs < expected && expected - serverMs < 60_000) return { serverMs: expected, monotonicMs };
  }
  return { serverMs, monotonicMs };
}

export function serverNow(clock: ServerClock | null, monotonicMs: number): number | null {
  return clock ? clock.serverMs + (monotonicMs - clock.monotonicMs) : null;
}

/// Age of a machine's values in ms; null: never heard, or no clock to say.
export function ageMs(live: Live | undefined, clock: ServerClock | null, monotonicMs: number): number | null {
  const now = serverNow(clock, monotonicMs);
  if (!live?.received || now === null) return null;
  return Math.max(0, now - Date.parse(live.received));
}

/// The state to show: never older than it may be.
export function shownState(live: Live | undefined, age: number | null): MachineState {
  if (!live || !live.connected || age === null || age > staleAfterMs) return "unknown";
  return live.state;
}

export function countStates(shop: Shop, monotonicMs: number): Map<MachineState, number> {
  const counts = new Map<MachineState, number>();
  for (const live of shop.machines.values()) {
    const state = shownState(live, ageMs(live, shop.clock, monotonicMs));
    counts.set(state, (counts.get(state) ?? 0) + 1);
  }
  return counts;
}
