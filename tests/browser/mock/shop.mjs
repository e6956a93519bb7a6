// A made-up shop for the mock: machines in every state, a few programs, alarms, transfers. Only tests look at it.
export const profiles = [
  { profile: "fanuc-0i-t", kind: "lathe", name: { en: "FANUC 0i-T", zh: "FANUC 0i-T 车床" } },
  { profile: "fanuc-0i-m", kind: "mill", name: { en: "FANUC 0i-M", zh: "FANUC 0i-M 铣床" } },
  { profile: "gsk-2000tc", kind: "lathe", name: { en: "GSK 2000TC", zh: "广州数控 GSK 2000TC" } },
];

export const lathe = `%
O1001 (STEPPED SHAFT)
G21 G40 G99
G50 S2500
T0101 (ROUGH 80 DEG)
G96 S180 M03
G00 X52. Z2.
G01 Z-60. F0.25
X54.
G00 Z2.
X46.
G01 Z-42. F0.25
X52.
G00 Z2.
X38.
G01 Z-25.
G02 X46. Z-29. R4.
G00 X60. Z5.
T0202 (FINISH)
G96 S220
G00 X30. Z1.
G01 Z0 F0.12
X38. Z-4.
Z-25.
G02 X46. Z-29. R4.
G01 Z-42.
X52. Z-45.
Z-60.
X56.
G00 X100. Z100.
M05
M30
%`;

export const mill = (() => {
  const rows = ["%", "O2001 (POCKET)", "G21 G17 G40 G49 G80 G90", "T1 M06", "S6000 M03", "G54 G00 X0 Y0", "G43 Z20. H1", "Z2."];
  for (let depth = 1; depth <= 5; depth += 1) {
    rows.push("G00 X0 Y0", `G01 Z-${depth}. F300`);
    for (let r = 5; r <= 30; r += 5) rows.push(`G01 X${r}. F900`, `G02 I-${r}. J0`);
  }
  rows.push("G00 Z50.", "M05", "M30", "%");
  return rows.join("\n");
})();

const states = ["running", "running", "running", "idle", "alarm", "hold", "stopped", "running", "unknown", "running", "idle", "setup", "running", "emergency_stop", "running", "off"];

export function makeMachine(id) {
  const kind = id % 3 === 2 ? 1 : id % 3 === 1 ? 0 : 2;
  const profile = profiles[kind];
  const isLathe = profile.kind === "lathe";
  const count = { lathe: Math.ceil(id / 3) * 2 - (kind === 0 ? 1 : 0), mill: Math.ceil(id / 3) }[profile.kind];
  return { id, name: `${isLathe ? "Lathe" : "Mill"} ${count}`, profile: profile.profile, isLathe, text: isLathe ? lathe : mill,
    state: states[(id - 1) % states.length], t: id * 7.3, parts: 12 + id, armed: id % 2 === 1, feed: id % 5 === 0 ? 80 : 100 };
}

export function plot(text, isLathe) {
  const axes = isLathe ? ["X", "Z"] : ["X", "Y", "Z"];
  let at = isLathe ? [100, 100] : [0, 0, 50], kind = "r";
  const moves = [{ k: "r", l: 1, p: [...at] }];
  text.split("\n").forEach((block, i) => {
    const words = Object.fromEntries([...block.replace(/\([^)]*\)/g, "").matchAll(/([A-Z])(-?[\d.]+)/g)].map((m) => [m[1], Number(m[2])]));
    if (/G0?0(?!\d)/.test(block)) kind = "r";
    if (/G0?1(?!\d)/.test(block)) kind = "f";
    if (words.I !== undefined) {
      const r = -words.I;
      for (let a = 0; a <= 48; a += 1) moves.push({ k: "a", l: i + 1, p: [r * Math.cos(a / 48 * 6.28319), -r * Math.sin(a / 48 * 6.28319), at[2]] });
      return;
    }
    const to = axes.map((axis, n) => words[axis] ?? at[n]);
    if (axes.some((axis) => words[axis] !== undefined) && !/G50|G43 H/.test(block)) moves.push({ k: /G0?2(?!\d)/.test(block) ? "a" : kind, l: i + 1, p: to });
    at = to;
  });
  return { axes, moves, truncated: false };
}

/// A plot goes out with X of a lathe as a radius.
export const inRadii = (path) => (path.axes.includes("Y") ? path : { ...path, moves: path.moves.map((move) => ({ ...move, p: [move.p[0] / 2, ...move.p.slice(1)] })) });

export function live(machine, now) {
  const unknown = machine.state === "unknown";
  const rows = machine.text.split("\n");
  const path = (machine.path ??= plot(machine.text, machine.isLathe));
  const cycle = 75, at = machine.state === "running" ? (machine.t % cycle) / cycle : 0.42;
  const index = Math.min(path.moves.length - 2, Math.floor(at * (path.moves.length - 1)));
  const part = at * (path.moves.length - 1) - index;
  const from = path.moves[index].p, to = path.moves[index + 1].p;
  const position = from.map((value, i) => value + (to[i] - value) * part);
  const line = path.moves[index + 1].l;
  const running = machine.state === "running";
  return {
    machine: machine.id, name: machine.name, profile: machine.profile, connected: !unknown, age_ms: unknown ? 8_040_000 : 120,
    received: new Date(now - (unknown ? 8_040_000 : 120)).toISOString(), state: machine.state, mode: machine.state === "setup" ? "jog" : "memory", remote_armed: machine.armed,
    program: { name: machine.isLathe ? "O1001" : "O2001", id: machine.isLathe ? 1 : 2, revision: 2, sha256: "ab".repeat(32), released: true },
    line, sequence: null, block: rows[line - 1] ?? "", progress: at, cycle_s: at * cycle, last_cycle_s: cycle, remaining_s: (1 - at) * cycle,
    parts: { count: machine.parts, required: 50, total: 1000 + machine.parts }, run_time_s: 9310, cutting_time_s: 7002,
    axes: path.axes, absolute: position, relative: position.map((v) => v / 2), machine_position: position.map((v) => v - 150), distance_to_go: to.map((v, i) => v - position[i]),
    feed: { actual_mm_min: running ? 180.4 : 0, commanded: 180 }, spindle: { actual_rpm: running ? 1432 : 0, commanded_rpm: 1432 },
    tool: 1, offset: 1, modal: machine.isLathe ? ["G01", "G97", "G69", "G99", "G21", "G40", "G25", "G22", "G80", "G67", "G54", "G64"] : ["G01", "G17", "G90", "G22", "G94", "G21", "G40", "G49", "G80", "G98", "G67", "G54", "G64"],
    overrides: { feed: machine.feed, rapid: 100, spindle: 100 },
    switches: { single_block: machine.id === 3, optional_stop: true, block_skip: false, dry_run: false, machine_lock: false },
    alarms: machine.state === "alarm" ? [{ id: 9, code: "OT0500", text: { en: "+ OVERTRAVEL ( SOFT 1 ): X axis", zh: "X 轴正向超程（软限位 1）" }, since: new Date(now - 190_000).toISOString(), line, program: "O1001" }] : [],
    trail: [], drip: null,
  };
}
