"""Programs that a machine asks the server for, and good-byes: a real server, a real agent."""
from shop import ShopTest, eventually

MAIN = """%
O2001 (CALLS THE SERVER)
G21 G17 G90 G94 G54
G00 X0. Y0. Z20.
M198 P1234 L2
G00 Z20.
M30
%
"""
# Each call goes 3 mm further; the machine's own O1234 would go elsewhere.
SUB = """%
O1234
G91 G01 X3. F3000.
G90
M99
%
"""
OTHER = """%
O1234
G01 Y50. F3000.
M99
%
"""
FED = """%
O4001
G21 G17 G90 G94 G54
G00 X0. Y0. Z20.
G01 X7. F3000.
M30
%
"""


class Requests(ShopTest):
    def setUp(self):
        super().setUp()
        self.shop.start_server()
        self.agent = self.shop.agent("Mill 1", "fanuc-0i-m", extra=["--clock", "fast"])
        self.agent.start()

    def released(self, name, text, folder=""):
        made = self.shop.upload(name, text, folder)
        program_id, revision = made["program"]["id"], made["revision"]["number"]
        check = self.shop.release(program_id, revision, self.agent)
        self.assertTrue(check["ok"], check)
        return program_id, revision

    def position(self, axis):
        status = self.agent.status()
        return status["absolute"][status["axes"].index(axis)]

    def sent(self, name):
        return [t for t in self.shop.admin.get("/transfers")["items"] if t["name"] == name]

    def load(self, name, text):
        import os
        path = os.path.join(self.shop.folder, name)
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
        self.agent.panel("load", path)
        return name

    def test_m198_gets_its_sub_program_from_the_server_each_time(self):
        self.released("O1234", SUB)
        self.load("O1234", OTHER)
        self.agent.panel("select", self.load("O2001", MAIN))
        self.agent.panel("start")
        eventually(lambda: self.agent.status()["parts"]["count"] == 1, "executed")
        eventually(lambda: abs(self.position("X") - 6) < 1e-3, "twice 3 mm")
        self.assertLess(abs(self.position("Y")), 1e-3)
        calls = eventually(lambda: (lambda t: t if len(t) == 2 and all(x["ended"] for x in t) else None)(self.sent("O1234")),
                           "both calls have their record")
        for call in calls:
            self.assertEqual((call["state"], call["kind"], call["by"]), ("done", "drip", f"machine:{self.agent.id}"), call)
            self.assertEqual((call["bytes"], call["drained"]), (len(SUB), True))

    def test_m198_of_what_is_not_released_is_an_alarm(self):
        self.shop.upload("O1234", SUB)
        self.load("O1234", OTHER)
        self.agent.panel("select", self.load("O2001", MAIN))
        self.agent.panel("start")
        eventually(lambda: self.agent.status()["state"] == "alarm", "alarm")
        self.assertLess(abs(self.position("Y")), 1e-3, "the resident program of that number was not taken instead")
        self.assertEqual(self.sent("O1234"), [])

    def test_an_operator_asks_for_a_program_to_be_fed(self):
        self.released("O4001", FED)
        self.agent.panel("request", "O4001")
        eventually(lambda: self.agent.status()["mode"] == "remote", "selected")
        self.assertEqual(self.agent.status()["state"], "idle", "nothing starts by itself")
        self.agent.panel("start")
        eventually(lambda: self.agent.status()["parts"]["count"] == 1, "executed")
        eventually(lambda: [t["state"] for t in self.sent("O4001")] == ["done"], "and recorded")

    def test_what_is_asked_for_in_vain_is_said_at_the_panel(self):
        self.shop.upload("O4001", FED)
        for name, reason in (("O4001", "not_released"), ("O5555", "not_found")):
            self.agent.panel("request", name)
            eventually(lambda: self.agent.status()["request"]["reason"] == reason, reason)
        self.released("O6001", FED.replace("O4001", "O6001"), "/a")
        self.released("O6001", FED.replace("O4001", "O6001"), "/b")
        self.agent.panel("request", "O6001")
        eventually(lambda: self.agent.status()["request"]["reason"] == "ambiguous", "nobody guesses")

    def test_switched_off_is_not_cut(self):
        eventually(lambda: self.agent.live()["connected"], "connected")
        self.assertEqual(self.agent.process.stop(), 0)
        eventually(lambda: self.agent.live()["state"] == "off", "shown as off, not as unknown")
        self.agent.start()
        self.assertEqual(self.shop.server.stop(), 0)
        eventually(lambda: "closed by the server: shutdown" in self.agent.process.text(), "the agent knows why")
        self.shop.start_server()
        eventually(lambda: self.agent.live()["connected"], "back")
        self.agent.process.kill9()
        eventually(lambda: self.agent.live()["state"] == "unknown", "a dead one is unknown")
