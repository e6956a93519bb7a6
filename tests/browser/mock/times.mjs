// Made-up times of the shop: for the pages, not for figures.
export const reasons = [["Setting up", "调机换型", false], ["Waiting for material", "待料", false], ["Machine fault", "设备故障", false], ["Maintenance", "计划保养", true], ["Break", "休息", true]]
  .map(([en, zh, planned], i) => ({ id: i + 1, name: { en, zh }, planned }));

/// A row whose sums hold: states and unknown fill the scheduled time.
export function row(machine, from, to, extra = {}) {
  const scheduled = (Date.parse(to) - Date.parse(from)) / 3000;
  const part = (share) => Math.round(scheduled * share);
  const states = { running: part(0.4 + (machine % 5) * 0.1), hold: part(0.03), alarm: part(machine % 3 === 0 ? 0.08 : 0.01), setup: part(0.05), off: machine % 7 === 0 ? part(0.1) : 0 };
  const unknown = machine % 4 === 1 ? part(0.06) : 0;
  states.idle = Math.max(0, scheduled - unknown - Object.values(states).reduce((a, b) => a + b, 0));
  const planned = part(0.05), base = scheduled - planned - unknown, parts = Math.floor(states.running / 80), ideal = parts * 75.4;
  const none = machine % 6 === 0 ? parts : 0;
  const availability = states.running / base, performance = none ? null : ideal / states.running, quality = parts ? (parts - 1) / parts : null;
  return { machine, from, to, day: null, shift: null, availability, performance, quality, oee: performance && quality ? availability * performance * quality : null,
    scheduled_s: scheduled, planned_s: base, planned_stop_s: planned, unknown_s: unknown, unexplained_s: Math.max(0, states.idle - planned - 900), states: { ...states, unknown: 0, stopped: 0, emergency_stop: 0 },
    reasons: [{ reason: 1, s: 900 }, { reason: 5, s: planned }], parts, rejects: parts ? 1 : 0, ideal_s: none ? 0 : ideal, parts_without_ideal: none, ...extra };
}

export function days(machine, from, to) {
  const rows = [];
  for (let at = Date.parse(from); at < Date.parse(to); at += 86_400_000) {
    const end = Math.min(at + 86_400_000, Date.parse(to)), start = new Date(at).toISOString();
    rows.push(row(machine + rows.length, start, new Date(end).toISOString(), { machine, day: start.slice(0, 10) }));
  }
  return rows;
}

/// What the machine did, one after the other.
export function intervals(machine, from, to) {
  const order = ["running", "idle", "running", "hold", "running", "setup", "running", "alarm", "running", "unknown", "off"];
  const found = [];
  for (let at = Date.parse(from), i = machine; at < Date.parse(to); i += 1) {
    const end = Math.min(at + (order[i % order.length] === "running" ? 5_400_000 : 1_500_000) + (i % 3) * 600_000, Date.parse(to));
    found.push({ state: order[i % order.length], mode: "memory", source: "machine", from: new Date(at).toISOString(), to: end === Date.parse(to) ? null : new Date(end).toISOString() });
    at = end;
  }
  return found;
}
