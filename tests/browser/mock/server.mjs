// node server.mjs --port 8090 --machines 6 --dist ../../../build/release/web/app/dist
// The contract of server/api/README.md with made-up answers: for work on the pages, and for what a real shop of two
// machines cannot show (sixty cards, every state). The tests of the whole path run against the real server.
import { keepingRoutes } from "./keeping.mjs";
import { createHash } from "node:crypto";
import { readFileSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { inRadii, lathe, live, makeMachine, mill, plot, profiles } from "./shop.mjs";
import { days, intervals, reasons, row } from "./times.mjs";
import { accept } from "./websocket.mjs";
import { root } from "../paths.mjs";

const mimes = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml" };

export function startMock({ port = 0, machines = 6, dist }) {
  const shop = Array.from({ length: machines }, (_, i) => makeMachine(i + 1));
  const links = new Set();
  const now = () => Date.now();
  const iso = (minutesAgo) => new Date(now() - minutesAgo * 60_000).toISOString();
  const users = [
    { id: 1, user: "admin", name: "Administrator", role: "administrator", language: "en", disabled: false, last_sign_in: iso(3) },
    { id: 2, user: "wang", name: "王师傅", role: "setter", language: "zh", disabled: false, last_sign_in: iso(400) },
    { id: 3, user: "li", name: "李工", role: "programmer", language: "zh", disabled: true, last_sign_in: null },
  ];
  const revision = (number, text, by, minutesAgo, note, released) => ({
    number, text, sha256: createHash("sha256").update(text).digest("hex"), bytes: Buffer.byteLength(text), lines: text.split("\n").length,
    encoding: "ascii", by, at: iso(minutesAgo), note, origin: "upload", released: released ? { by: "wang", at: iso(minutesAgo - 10), why: "first piece measured" } : null,
  });
  const programs = [
    { id: 1, folder: "/shafts", name: "O1001", revisions: [revision(1, lathe.replaceAll("F0.12", "F0.15").replace("X46. Z-29. R4.", "X46. Z-28.5 R4."), "li", 9000, "first version", false), revision(2, lathe, "li", 2000, "finishing feed lowered for the new insert", true)] },
    { id: 2, folder: "/housings", name: "O2001", revisions: [revision(1, mill.replace("F900", "F800"), "li", 7000, "", false), revision(2, mill, "wang", 900, "pocket in five depths", true)] },
    { id: 3, folder: "/shafts/long", name: "O1203", revisions: [revision(1, lathe.replace("O1001", "O1203"), "wang", 400, "", false)] },
  ];
  // Five million lines that exist only where one looks.
  programs.push({ id: 4, folder: "/shafts/long", name: "MOULD", revisions: [{ ...revision(1, "", "li", 100, "finishing, 0.02 mm steps", false), lines: 5_000_000, bytes: 96 << 20 }] });
  const plain = ({ text, ...rest }) => rest;
  const shown = (p) => ({ id: p.id, folder: p.folder, name: p.name, newest: plain(p.revisions.at(-1)), released: p.revisions.filter((r) => r.released).map(plain).at(-1) ?? null });
  const alarms = shop.flatMap((m) => [1, 2].map((n) => ({ id: m.id * 10 + n, machine: m.id, code: n === 1 ? "OT0500" : "PS0010", text: n === 1 ? { en: "+ OVERTRAVEL ( SOFT 1 ): X axis", zh: "X 轴正向超程（软限位 1）" } : { en: "IMPROPER G-CODE", zh: "G 代码不正确" }, since: iso(n * 90 + m.id * 7), cleared: n === 1 && m.state === "alarm" ? null : iso(n * 90 + m.id * 7 - 4), line: 12 + n, program: "O1001", block: "G01 X520. F0.2" })));
  const stops = [[300, 270, "idle", 1], [200, 185, "alarm", 3], [120, 70, "idle", null], [9, 0, "hold", null]].map(([from, to, state, reason]) => ({ from: iso(from), to: iso(to), state, open: to === 0, note: reason ? { id: reason, reason, note: "", by: "wang", at: iso(60) } : null }));
  const calendar = { time_zone: "Asia/Shanghai", shifts: [{ name: "白班", days: [1, 2, 3, 4, 5], start: "08:00", end: "20:00" }] };
  const transfers = new Map();
  let session = null;
  const rights = (role) => ["viewer", "operator", "programmer", "setter", "administrator"].indexOf(role);
  const fail = (status, code, en, zh) => ({ status, body: { error: { code, message: { en, zh }, where: "" } } });
  const machine = (m) => ({ id: m.id, name: m.name, profile: m.profile, live: live(m, now()), axes: m.isLathe ? [{ name: "X", min_mm: -10, max_mm: 120, diameter: true }, { name: "Z", min_mm: -400, max_mm: 200 }] : [{ name: "X", min_mm: -300, max_mm: 300 }, { name: "Y", min_mm: -200, max_mm: 200 }, { name: "Z", min_mm: -200, max_mm: 100 }], toml: "[machine]\n" });

  function diff(a, b) {
    const left = a.split("\n"), right = b.split("\n");
    return { rows: left.map((text, i) => ({ kind: text === right[i] ? "same" : "changed", left: text, right: right[i], left_line: i + 1, right_line: i + 1, class: text === right[i] ? null : /F/.test(text) && !/R/.test(text) ? "feed_speed" : "geometry" })), classes: ["feed_speed", "geometry"] };
  }
  function send(kind, program, number, id) {
    const t = { id: transfers.size + 1, machine: id, program, revision: number, kind, state: "sending", bytes: 0, total: 1 << 20, rate: 350_000, reason: null, started: iso(0), ended: null };
    transfers.set(t.id, t);
    return t;
  }

  // method, path pattern, answer(match, {query, body})
  const routes = [
    ["POST", /^\/session$/, (_, { body }) => { const user = users.find((u) => u.user === body.user); if (!user || body.password !== "secret12") return fail(401, "bad_credentials", "User or password is wrong.", "用户名或密码错误。"); session = { ...user, must_change_password: false }; return session; }],
    ["GET", /^\/session$/, () => session ?? fail(401, "unauthorized", "Sign in first.", "请先登录。")],
    ["DELETE", /^\/session$/, () => { session = null; return {}; }],
    ["POST", /^\/session\/password$/, () => ({})],
    ["GET", /^\/users$/, () => users], ["POST", /^\/users$/, (_, { body }) => { users.push({ id: users.length + 1, disabled: false, last_sign_in: null, ...body }); return users.at(-1); }],
    ["PATCH", /^\/users\/(\d+)$/, ([, id], { body }) => Object.assign(users.find((u) => u.id === Number(id)), body)],
    ["DELETE", /^\/users\/(\d+)$/, ([, id]) => { users.splice(users.findIndex((u) => u.id === Number(id)), 1); return {}; }],
    ...keepingRoutes({ iso, users, shop }),
    ["GET", /^\/profiles$/, () => profiles],
    ["GET", /^\/machines$/, () => shop.map(machine)],
    ["POST", /^\/machines$/, (_, { body }) => { const made = { ...makeMachine(shop.length + 1), name: body.name, profile: body.profile, state: "unknown" }; shop.push(made); return { ...machine(made), enrolment_token: "HS1-7d1c-example" }; }],
    ["GET", /^\/machines\/(\d+)$/, ([, id]) => { const m = shop[id - 1]; return m ? machine(m) : fail(404, "not_found", "No such machine.", "没有此机床。"); }],
    ["GET", /^\/machines\/(\d+)\/programs$/, ([, id]) => [{ name: shop[id - 1].isLathe ? "O1001" : "O2001", sha256: "ab", bytes: 600, since: iso(600), selected: true, program_id: 1, revision: 2, stale: false }, { name: "O1203", sha256: "cd", bytes: 412, since: iso(6000), program_id: 3, revision: 1, stale: true }, { name: "O9001", sha256: "ef", bytes: 90, since: iso(90000), program_id: null, revision: null, stale: null }]],
    ["POST", /^\/machines\/(\d+)\/commands$/, ([, id], { body }) => { const m = shop[id - 1]; if (body.action === "cycle_start") { if (!m.armed) return { status: 409, body: { accepted: false, reason: "not_armed", error: { code: "not_armed", message: { en: "Remote operation is not armed.", zh: "未允许远程操作。" } } } }; m.state = "running"; } if (body.action === "feed_hold") m.state = "hold"; if (body.action === "reset") m.state = "idle"; if (body.action === "set_feed_override") m.feed = Math.round(body.value * 100); return { accepted: true, reason: "" }; }],
    ["POST", /^\/machines\/(\d+)\/select$/, () => ({ accepted: true, reason: "" })],
    ["POST", /^\/machines\/(\d+)\/drip$/, ([, id], { body }) => send("drip", body.program_id, body.revision, Number(id))],
    ["GET", /^\/machines\/(\d+)\/runs$/, () => ({ items: [1, 2, 3].map((n) => ({ id: n, program: "O1001", revision: 2, started: iso(n * 3), ended: iso(n * 3 - 1.2), outcome: n === 2 ? "reset" : "completed", run_s: 75, cutting_s: 61 })), next: null })],
    ["GET", /^\/machines\/(\d+)\/offsets$/, () => ({ items: [] })],
    ["GET", /^\/folders$/, () => ({ items: ["/shafts", "/shafts/long", "/housings"], next: null })], ["POST", /^\/folders$/, () => ({})],
    ["GET", /^\/programs$/, (_, { query }) => ({ items: programs.filter((p) => (!query.get("folder") || p.folder.startsWith(query.get("folder"))) && (!query.get("q") || p.name.includes(query.get("q")))).map(shown), next: null })],
    ["POST", /^\/programs$/, (_, { query, bytes }) => { const text = bytes.toString(); if (text === "") return fail(422, "empty", "The file is empty.", "文件是空的。"); const name = query.get("name").replace(/\.[^.]*$/, ""); let p = programs.find((one) => one.name === name && one.folder === query.get("folder")); const created = !p; if (!p) { p = { id: programs.length + 1, folder: query.get("folder"), name, revisions: [] }; programs.push(p); } const r = revision(p.revisions.length + 1, text, session.user, 0, query.get("note") ?? "", false); p.revisions.push(r); return { program: shown(p), revision: plain(r), created, duplicate_of: null }; }],
    ["GET", /^\/programs\/(\d+)$/, ([, id]) => shown(programs[id - 1])],
    ["GET", /^\/programs\/(\d+)\/revisions$/, ([, id]) => ({ items: programs[id - 1].revisions.map(plain), next: null })],
    ["GET", /^\/programs\/(\d+)\/revisions\/(\d+)\/content$/, ([, id, n], { query }) => { const from = Number(query.get("from_line") ?? 1); if (id === "4") { const count = Math.min(Number(query.get("lines")), 5_000_001 - from); return { from, total: 5_000_000, lines: Array.from({ length: count }, (_, i) => `N${from + i} G01 X${((from + i) % 900) / 10} Z-0.02`), cut: [] }; } const rows = programs[id - 1].revisions[n - 1].text.split("\n"); return { raw: rows.slice(from - 1, query.get("lines") ? from - 1 + Number(query.get("lines")) : undefined).join("\n") }; }],
    ["GET", /^\/programs\/(\d+)\/diff$/, ([, id], { query }) => diff(programs[id - 1].revisions[query.get("from") - 1].text, programs[id - 1].revisions[query.get("to") - 1].text)],
    ["POST", /^\/programs\/(\d+)\/revisions\/(\d+)\/check$/, ([, id], { body }) => body.machine % 3 === 2 && id === "1" ? { ok: false, findings: [{ line: 12, column: 5, code: "PS0010", text: { en: "IMPROPER G-CODE: G96", zh: "G 代码不正确：G96" } }, { line: 17, column: 1, code: "PS0020", text: { en: "OVER TOLERANCE OF RADIUS", zh: "超过半径公差" } }], time_s: null, cutting_s: null, length_mm: null } : { ok: true, findings: [], time_s: 75.4, cutting_s: 61.2, length_mm: 1240.5, tools: [1, 2] }],
    ["GET", /^\/programs\/(\d+)\/revisions\/(\d+)\/backplot$/, ([, id, n]) => inRadii(plot(programs[id - 1].revisions[n - 1].text, id !== "2"))],
    ["POST", /^\/programs\/(\d+)\/revisions\/(\d+)\/release$/, ([, id, n], { body }) => { programs[id - 1].revisions[n - 1].released = { by: session.user, at: iso(0), why: body.why }; return {}; }],
    ["DELETE", /^\/programs\/(\d+)\/release$/, ([, id]) => { for (const r of programs[id - 1].revisions) r.released = null; return {}; }],
    ["POST", /^\/distributions$/, (_, { body }) => ({ id: 1, program: body.program, revision: body.revision, transfers: body.machines.map((id) => send("put", body.program, body.revision, id)) })],
    ["GET", /^\/transfers$/, () => ({ items: [...transfers.values()].reverse(), next: null })],
    ["GET", /^\/alarms$/, (_, { query }) => ({ items: alarms.filter((a) => (!query.get("machine") || a.machine === Number(query.get("machine"))) && (!query.get("code") || a.code.includes(query.get("code"))) && (query.get("active") !== "true" || !a.cleared)).sort((a, b) => b.since.localeCompare(a.since)), next: null })],
    ["GET", /^\/oee$/, (_, { query }) => ({ items: query.get("by") ? days(Number(query.get("machine")), query.get("from"), query.get("to")) : shop.map((m) => row(m.id, query.get("from"), query.get("to"))), next: null })],
    ["GET", /^\/calendar$/, () => calendar],
    ["PATCH", /^\/calendar$/, (_, { body }) => Object.assign(calendar, body)],
    ["GET", /^\/alarms\/statistics$/, () => ({ items: ["OT0500", "PS0010", "SV0401"].map((code, n) => ({ code, text: { en: ["+ OVERTRAVEL ( SOFT 1 )", "IMPROPER G-CODE", "V-READY OFF"][n], zh: ["正向超程（软限位 1）", "G 代码不正确", "伺服准备信号断开"][n] }, count: 12 - 3 * n, active_s: 9000 / (n + 1), machines: 3 - n, last: iso(40 * n) })), next: null })],
    ["GET", /^\/downtime-reasons$/, () => ({ items: reasons, next: null })],
    ["GET", /^\/machines\/(\d+)\/states$/, ([, id], { query }) => ({ items: intervals(Number(id), query.get("from"), query.get("to")), next: null })],
    ["GET", /^\/machines\/(\d+)\/stops$/, () => ({ items: stops, next: null })],
    ["POST", /^\/machines\/(\d+)\/downtime$/, (_, { body }) => { const stop = stops.find((one) => one.from === body.from); stop.note = body.reason ? { id: 9, reason: body.reason, note: "", by: session.user, at: iso(0) } : null; return { id: 9 }; }],
    ["POST", /^\/machines\/(\d+)\/rejects$/, () => ({ id: 1 })],
  ];

  const server = createServer((request, response) => {
    const url = new URL(request.url, "http://mock");
    const chunks = [];
    request.on("data", (chunk) => chunks.push(chunk));
    request.on("end", () => {
      if (!url.pathname.startsWith("/api/v1")) {
        let file = join(dist, url.pathname);
        try { if (statSync(file).isDirectory()) file = join(file, "index.html"); } catch { response.writeHead(404).end(); return; }
        response.writeHead(200, { "Content-Type": mimes[extname(file)] ?? "application/octet-stream" }).end(readFileSync(file));
        return;
      }
      const path = url.pathname.slice(7);
      for (const [method, pattern, answer] of routes) {
        const match = method === request.method && path.match(pattern);
        if (!match) continue;
        const bytes = Buffer.concat(chunks);
        let body = {};
        if (request.headers["content-type"] === "application/json" && bytes.length > 0) body = JSON.parse(bytes);
        const got = answer(match, { query: url.searchParams, body, bytes });
        if (got.raw !== undefined) response.writeHead(200, { "Content-Type": "text/plain; charset=utf-8" }).end(got.raw);
        else response.writeHead(got.body ? got.status : 200, { "Content-Type": "application/json" }).end(JSON.stringify(got.body ?? got));
        return;
      }
      response.writeHead(404, { "Content-Type": "application/json" }).end(JSON.stringify({ error: { code: "not_found", message: { en: `${request.method} ${path}`, zh: path } } }));
    });
  });
  server.on("upgrade", (request, socket) => {
    const link = accept(request, socket);
    links.add(link);
    link.onclose = () => links.delete(link);
    link.send(JSON.stringify({ type: "snapshot", now: iso(0), machines: shop.map((m) => live(m, now())) }));
  });
  const tell = (message) => { for (const link of links) link.send(JSON.stringify(message)); };
  const timers = [
    setInterval(() => tell({ type: "tick", now: iso(0) }), 1000),
    setInterval(() => {
      for (const m of shop) { if (m.state === "running") m.t += 0.5; if (m.state !== "unknown") tell({ type: "live", machine: m.id, live: live(m, now()) }); }
      for (const t of transfers.values()) {
        if (t.state !== "sending") continue;
        t.bytes = Math.min(t.total, t.bytes + 180_000);
        if (t.bytes === t.total) { t.state = t.machine % 4 === 0 ? "failed" : "done"; t.reason = t.machine % 4 === 0 ? "memory_full" : null; t.ended = iso(0); }
        tell({ ...t, type: "transfer" });
      }
    }, 500),
  ];
  return new Promise((resolve) => server.listen(port, "127.0.0.1", () => resolve({
    url: `http://127.0.0.1:${server.address().port}`, user: "admin", password: "secret12",
    stop: () => { timers.forEach(clearInterval); for (const link of links) link.close(); server.closeAllConnections(); server.close(); },
  })));
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const option = (name, otherwise) => { const at = process.argv.indexOf(`--${name}`); return at > 0 ? process.argv[at + 1] : otherwise; };
  const mock = await startMock({ port: Number(option("port", 8090)), machines: Number(option("machines", 6)), dist: option("dist", join(root, "build/release/web/app/dist")) });
  console.log(`${mock.url}  user ${mock.user}  password ${mock.password}`);
}
