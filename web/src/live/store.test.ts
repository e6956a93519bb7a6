import { describe, expect, it } from "vitest";
import type { Live } from "../api/types";
import { ageMs, countStates, emptyShop, lost, receive, serverNow, shownState, type Shop } from "./store";

const t0 = "2026-01-01T00:00:00.000Z";
const live = (machine: number, more: Partial<Live> = {}): Live =>
  ({ machine, name: `M${machine}`, connected: true, received: t0, age_ms: 100, state: "running", ...more }) as Live;
const snapshot = (shop: Shop, machines: Live[], at = 1000) => receive(shop, { type: "snapshot", machines }, at);

describe("the age of what is shown", () => {
  it("counts from the server's clock, not from this computer's", () => {
    const shop = snapshot(emptyShop, [live(1)]);
    expect(serverNow(shop.clock, 1000)).toBe(Date.parse(t0) + 100);
    expect(ageMs(shop.machines.get(1), shop.clock, 3500)).toBe(2600);
  });
  it("goes on growing when the link is lost, until the machine is unknown", () => {
    const shop = lost(snapshot(emptyShop, [live(1)]), 2000);
    const seen = shop.machines.get(1);
    expect(shop.link).toBe("lost");
    expect(shownState(seen, ageMs(seen, shop.clock, 5000))).toBe("running");
    expect(shownState(seen, ageMs(seen, shop.clock, 8000))).toBe("unknown");
  });
  it("is never made younger by a tick that was late on its way", () => {
    let shop = snapshot(emptyShop, [live(1)]);
    shop = receive(shop, { type: "tick", now: "2026-01-01T00:00:05.000Z" }, 5900);
    shop = receive(shop, { type: "tick", now: "2026-01-01T00:00:05.500Z" }, 8900);   // 2.5 s late
    expect(ageMs(shop.machines.get(1), shop.clock, 8900)).toBe(8000);
  });
  it("believes a server whose clock was set back by more than a minute", () => {
    let shop = snapshot(emptyShop, [live(1)]);
    shop = receive(shop, { type: "tick", now: "2025-12-31T20:00:00.000Z" }, 2000);
    expect(serverNow(shop.clock, 2000)).toBe(Date.parse("2025-12-31T20:00:00.000Z"));
  });
});

describe("unknown", () => {
  it("is what a machine is that was never heard, is not connected, or is too old; never idle", () => {
    expect(shownState(undefined, null)).toBe("unknown");
    expect(shownState(live(1, { received: null, state: "idle" }), null)).toBe("unknown");
    expect(shownState(live(1, { connected: false, state: "idle" }), 10)).toBe("unknown");
    expect(shownState(live(1, { state: "idle" }), 6001)).toBe("unknown");
    expect(shownState(live(1, { state: "idle" }), 6000)).toBe("idle");
  });
  it("is counted as a state of its own", () => {
    const shop = snapshot(emptyShop, [live(1), live(2, { connected: false }), live(3, { state: "alarm" })]);
    expect(Object.fromEntries(countStates(shop, 1000))).toEqual({ running: 1, unknown: 1, alarm: 1 });
  });
});

describe("messages", () => {
  it("replace one machine and leave the others as they were", () => {
    const before = snapshot(emptyShop, [live(1), live(2)]);
    const after = receive(before, { type: "live", machine: 1, live: live(1, { state: "hold" }) }, 1100);
    expect(after.machines.get(1)?.state).toBe("hold");
    expect(after.machines.get(2)).toBe(before.machines.get(2));
  });
  it("of a newer server are ignored", () => {
    expect(receive(emptyShop, { type: "weather" } as never, 1)).toBe(emptyShop);
  });
  it("keep a transfer whether it comes flat or wrapped", () => {
    let shop = receive(emptyShop, { type: "transfer", id: 4, state: "sending" } as never, 1);
    shop = receive(shop, { type: "transfer", transfer: { id: 5, state: "done" } } as never, 1);
    expect([...shop.transfers.keys()]).toEqual([4, 5]);
  });
});
