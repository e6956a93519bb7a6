"""A program that passes a soft limit: axes stop before it, the controller's own alarm is on the card, reset clears it."""
from datetime import datetime, timezone

from shop import ApiError, ShopTest, eventually

# One move far outside every default machine's stroke; the first move is inside.
PROGRAMS = {
    "fanuc-0i-t": ("O1666", "O1666\nG21 G98\nG00 X100. Z50.\nG01 Z-9999. F3000.\nM30\n%\n"),
    "fanuc-0i-m": ("O2666", "O2666\nG21 G90 G94\nG00 X10. Y10. Z10.\nG01 X9999. F3000.\nM30\n%\n"),
    "gsk-2000tc": ("O0666", "O0666\nG98\nG0 X100.0 Z50.0\nG1 Z-9999.0 F3000\nM30\n%\n"),
}


def when(text):
    return datetime.fromisoformat(text.replace("Z", "+00:00"))


class SoftLimit(ShopTest):
    def overtravel(self, profile):
        agent = self.shop.agent("Machine " + profile, profile).start()
        name, text = PROGRAMS[profile]
        made = self.shop.upload(name, text)
        program_id, revision = made["program"]["id"], made["revision"]["number"]
        check = self.shop.admin.call("POST", f"/programs/{program_id}/revisions/{revision}/check", {"machine": agent.id})
        self.assertFalse(check["ok"], "the check must see the over-travel before any machine does")
        # A person at the machine can still load it: the machine must protect itself.
        path = f"{self.shop.folder}/{name}"
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
        agent.panel("load", path)
        agent.panel("select", name)
        agent.panel("start")
        seen = eventually(lambda: agent.live()["alarms"], "alarm on the card")
        seen_at = datetime.now(timezone.utc)
        # Raised at the machine, seen by a client of the server: both clocks are this machine's.
        self.assertLess((seen_at - when(seen[0]["since"])).total_seconds(), 1.0)
        live = eventually(lambda: (lambda l: l if l["state"] == "alarm" else None)(agent.live()), "stopped with the alarm")
        alarm = live["alarms"][0]
        self.assertTrue(alarm["code"] and alarm["text"]["en"] and alarm["text"]["zh"], alarm)
        self.assertTrue(any(ord(c) > 0x2E80 for c in alarm["text"]["zh"]), alarm)
        limits = {axis["name"]: axis for axis in self.shop.admin.get(f"/machines/{agent.id}")["axes"]}
        for axis, position in zip(live["axes"], live["machine_position"]):
            self.assertGreaterEqual(position, limits[axis]["min_mm"] - 1e-6)
            self.assertLessEqual(position, limits[axis]["max_mm"] + 1e-6)
        history = self.shop.admin.get("/alarms", machine=agent.id)["items"]
        self.assertEqual([row["code"] for row in history], [alarm["code"]])
        with self.assertRaises(ApiError) as refused:   # nobody may clear from afar what was not armed here
            agent.command("reset")
        self.assertEqual(refused.exception.reason, "not_armed")
        agent.panel("reset")
        eventually(lambda: not agent.live()["alarms"], "alarm cleared by reset")
        eventually(lambda: self.shop.admin.get("/alarms", machine=agent.id)["items"][0]["cleared"], "cleared in history")
        self.assertEqual(agent.parts(), 0)
        return alarm["code"]

    def test_each_controller_stops_before_its_limit_with_its_own_alarm(self):
        self.shop.start_server()
        codes = {profile: self.overtravel(profile) for profile in PROGRAMS}
        self.assertTrue(codes["fanuc-0i-t"].startswith("OT05"), codes)
        self.assertTrue(codes["fanuc-0i-m"].startswith("OT05"), codes)
        self.assertFalse(codes["gsk-2000tc"].startswith("OT"), codes)
