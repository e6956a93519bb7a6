// What an administrator keeps the shop with, made up: rights, screens, audit, backups, alarm rules.
export function keepingRoutes({ iso, shop }) {
  const list = (items) => ({ items, next: null });
  const actions = ["command_machine", "select_program", "release_program", "edit_offsets", "edit_machine", "acknowledge_alarm"];
  const groups = [{ id: 1, name: "车削单元 A", machines: [1, 3, 4, 6] }, { id: 2, name: "Mills", machines: [2, 5, 8] }];
  const audit = [["wang", "program.release", "program:7", { why: "first piece measured", revision: "2" }], ["li", "offset.change", "machine:3", { what: "T03 wear X", before: "-0.02", after: "-0.05" }],
    ["admin", "user.grants", "user:4", { user: "chen", grants: "setter on group:1; not command_machine on machine:5" }], ["server", "backup.make", "backup:12", { file: "headstock-server-2026-01-01.tar.zst", kind: "server" }],
    ["chen", "session.refused", "user:4", { failures: "2" }], ["zhao", "alarm.acknowledge", "alarm_event:31", { machine: "Lathe 3", code: "OT0500", note: "on my way" }]]
    .map(([user, action, subject, detail], n) => ({ id: 4211 - n, at: iso(7 + n * 23), user, address: user === "server" ? "" : `192.168.1.${20 + n}`, action, subject, detail, hash: "ab" }));
  const backups = [{ id: 12, file: "headstock-server-2026-01-12T02-00-00-000Z.tar.zst", kind: "server", machine: null, sha256: "9f".repeat(32), bytes: 84_213_760, by: "server", at: iso(500) },
    { id: 11, file: "headstock-lathe-1-1-2026-01-11T16-20-41-000Z.tar.zst", kind: "machine", machine: 1, sha256: "3c".repeat(32), bytes: 41_200, by: "wang", at: iso(1100) }];
  const rules = [{ id: 1, name: "超程与伺服", machine: null, group: 1, code: "OT*", after_s: 0, email: "maintenance@example.com", webhook: "", escalate_after_s: 900, escalate_email: "foreman@example.com", escalate_webhook: "", again_after_s: 300, enabled: true },
    { id: 2, name: "Night shift", machine: null, group: null, code: "", after_s: 120, email: "", webhook: "https://chat.example.com/hook/headstock", escalate_after_s: 0, escalate_email: "", escalate_webhook: "", again_after_s: 600, enabled: false }];
  const events = [["OT0500", "正向超程（软限位 1）", "+ OVERTRAVEL ( SOFT 1 )", 3, 12, null, null], ["SV0401", "伺服准备信号关", "V-READY OFF", 5, 75, null, { at: iso(70), by: "zhao", note: "on my way" }], ["OT0500", "正向超程（软限位 1）", "+ OVERTRAVEL ( SOFT 1 )", 1, 300, iso(280), null]]
    .map(([code, zh, en, machine, minutes, cleared, acknowledged], n) => ({ id: 31 - n, rule: "超程与伺服", machine, machine_name: shop[machine - 1].name, code, text: { zh, en }, first: iso(minutes), last: iso(minutes - 5), times: n + 1, cleared, escalated: n === 0 ? iso(2) : null, acknowledged }));
  return [
    ["GET", /^\/users\/(\d+)\/grants$/, () => list([{ machine: null, group: 1, role: "setter", action: null, allow: true }, { machine: 5, group: null, role: null, action: "command_machine", allow: false }])],
    ["GET", /^\/permissions$/, () => list(actions.map((action) => ({ action, role: "operator" })))],
    ["GET", /^\/machine-groups$/, () => list(groups)],
    ["GET", /^\/view-tokens$/, () => list([{ id: 1, name: "一号车间大屏", by: "admin", created: iso(9000), expires: null, last_used: iso(1) }])],
    ["POST", /^\/view-tokens$/, (_, { body }) => ({ id: 2, name: body.name, token: "5e".repeat(32) })],
    ["GET", /^\/settings\/sign-in$/, () => ({ session_hours: 12, idle_minutes: 60, least_password: 8 })],
    ["GET", /^\/settings\/provider$/, () => ({ issuer: "", client_id: "", client_secret_set: false, label: "", create: false, role: "viewer" })],
    ["GET", /^\/sign-in-provider$/, () => ({ enabled: false, label: "" })],
    ["GET", /^\/settings\/messages$/, () => ({ mail_url: "smtp://mail.example.com:587", mail_user: "headstock", mail_password_set: true, mail_from: "Headstock <headstock@example.com>", mail_tls: true, webhook_secret_set: true, link: "https://headstock.example.com" })],
    ["GET", /^\/settings\/keeping$/, () => ({ backup_every_hours: 24, backups_kept: 7, states_days: 365, events_days: 730, transfers_days: 180 })],
    ["GET", /^\/audit$/, () => list(audit)],
    ["GET", /^\/audit\/verification$/, () => ({ whole: true, broken: null, what: "", rows: 4211, hash: "7be1c09a44d2f0138ac9" })],
    ["GET", /^\/backups$/, () => list(backups)],
    ["GET", /^\/alarm-rules$/, () => list(rules)],
    ["GET", /^\/alarm-events$/, () => list(events)],
  ];
}
