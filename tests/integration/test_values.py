"""Machine values, governed: every change known, nothing overwritten unseen, done only when read back, whatever dies."""
import http.client
import os
import random
import subprocess
import threading
import time

from shop import ApiError, Client, ShopTest, eventually, program

# Writes wear offset 3 with G10 on every run and takes a while, so that the others come in between.
G10 = "O10\nG21 G98\nG10 P3 {word}\nG00 X40. Z2.\nG01 Z-8. F1200.\nG00 X50. Z10.\nM30\n%\n"
WEAR = "tool/3/wear/X"


class Values(ShopTest):
    def setUp(self):
        super().setUp()
        self.shop.start_server()
        self.setter = self.person("wang", "setter")
        self.second = self.person("li", "setter")

    def person(self, user, role):
        self.shop.admin.post("/users", {"user": user, "password": "correct horse 7", "role": role,
                                        "must_change_password": False})
        return Client(self.shop.admin.base).sign_in(user, "correct horse 7")

    def agent(self, name="Lathe 1", **more):
        agent = self.shop.agent(name, "fanuc-0i-t", **more).start()
        eventually(lambda: self.page(agent)["reported"], "the machine has told what it has")
        return agent

    def page(self, agent, kind=""):
        return self.shop.admin.get(f"/machines/{agent.id}/values", kind=kind)

    def value(self, agent, what):
        return self.page(agent)["values"].get(what, 0)

    def write(self, agent, what, after, before=None, who=None, origin="person"):
        seen = self.value(agent, what) if before is None else before
        return (who or self.setter).post(f"/machines/{agent.id}/values", {
            "values": [{"what": what, "before": seen, "after": after}], "origin": origin})

    def history(self, agent, what):
        return self.shop.admin.get(f"/machines/{agent.id}/value-changes", what=what, limit=1000)["items"]

    def on_machine(self, agent, what):
        """As the agent itself has it on its disk: after a kill it has nothing else."""
        agent.process.kill9()
        agent.start()
        return float(agent.panel("value", what))

    def refused(self, code, call):
        with self.assertRaises(ApiError) as caught:
            call()
        self.assertEqual(caught.exception.code, code, caught.exception)
        return caught.exception

    def test_written_read_back_and_kept(self):
        agent = self.agent()
        done = self.write(agent, WEAR, 0.02)
        self.assertEqual(done["state"], "done", done)
        self.assertEqual(done["values"][0]["read_back"], 0.02)
        newest = eventually(lambda: self.history(agent, WEAR), "history")[0]
        self.assertEqual((newest["by"], newest["origin"], newest["before"], newest["after"], newest["request"]),
                         ("wang", "person", 0, 0.02, done["id"]))
        agent.process.kill9()
        agent.start()
        self.assertEqual(self.value(agent, WEAR), 0.02)
        self.assertEqual(len(self.history(agent, WEAR)), 1, "a restart is no change")

    def test_a_touched_place_becomes_an_offset(self):
        agent = self.agent()
        what = "tool/3/geometry/X"
        self.write(agent, WEAR, 0.02)
        shown = agent.status()["absolute"][0]
        agent.panel("touch", f"{what}={shown - 12.5}")
        newest = eventually(lambda: self.history(agent, what), "history")[0]
        self.assertEqual((newest["origin"], newest["before"]), ("measurement", 0))
        self.assertAlmostEqual(newest["after"], 12.5, 6)
        self.assertEqual(self.history(agent, WEAR)[0]["after"], 0, "the measured offset has no wear")
        with self.assertRaises(OSError):
            agent.panel("touch", "work/G57/X=0")  # another system is in force
        self.assertAlmostEqual(self.on_machine(agent, what), 12.5, 6)

    def test_two_people_on_one_offset(self):
        agent = self.agent()
        self.write(agent, WEAR, 0.02)
        refusal = self.refused("changed_meanwhile", lambda: self.write(agent, WEAR, 0.05, before=0.0, who=self.second))
        self.assertEqual(refusal.error["where"], WEAR)
        self.assertEqual(self.value(agent, WEAR), 0.02)

    def test_a_large_step_needs_a_second_person(self):
        agent = self.agent()
        asked = self.write(agent, WEAR, 0.5)
        self.assertEqual((asked["state"], asked["needs_second"]), ("waiting", WEAR))
        self.assertEqual(self.value(agent, WEAR), 0, "nothing is written before that")
        self.refused("same_person", lambda: self.setter.post(f"/value-requests/{asked['id']}/agree"))
        agreed = self.second.post(f"/value-requests/{asked['id']}/agree")
        self.assertEqual((agreed["state"], agreed["second"]), ("done", "li"))
        eventually(lambda: self.value(agent, WEAR) == 0.5, "written")
        # What was agreed to must still be what is there.
        again = self.write(agent, WEAR, 1.5)
        agent.panel("set", f"{WEAR}=0.6")
        with self.assertRaises(ApiError) as caught:
            self.second.post(f"/value-requests/{again['id']}/agree")
        self.assertEqual(caught.exception.reason, "changed_meanwhile")
        eventually(lambda: self.value(agent, WEAR) == 0.6, "the panel's value stays")

    def test_bad_values_say_what_is_wrong_and_change_nothing(self):
        agent = self.agent()
        for what, value in (("tool/201/wear/X", 0.1), ("tool/3/wear/Y", 0.1), ("tool/3/geometry/X", 20000),
                            ("tool/3/tip", 11), ("work/G54.1P1/X", 1), ("parameter/99999", 1), ("variable/300", 1)):
            before = 0 if what[0] in "tw" else None
            refusal = self.refused("value_refused", lambda: self.setter.post(f"/machines/{agent.id}/values", {
                "values": [{"what": what, "before": before, "after": value}]}))
            self.assertTrue(refusal.error["where"].startswith(what), refusal)
        refusal = self.refused("machine_refused", lambda: self.setter.post(f"/machines/{agent.id}/values", {
            "values": [{"what": "parameter/6713", "before": None, "after": 50}]}))
        self.assertEqual(refusal.reason, "parameter_write_off", "the switch at the machine is off")
        agent.panel("parameter-write", "on")
        refusal = self.refused("machine_refused", lambda: self.setter.post(f"/machines/{agent.id}/values", {
            "values": [{"what": "parameter/6713", "before": None, "after": 50}]}))
        self.assertEqual(refusal.reason, "not_mdi")
        agent.panel("mode", "mdi")
        done = self.setter.post(f"/machines/{agent.id}/values", {
            "values": [{"what": "parameter/6713", "before": None, "after": 50}]})
        self.assertEqual(done["state"], "done")
        self.assertEqual([one["code"] for one in eventually(lambda: agent.live()["alarms"], "the open switch is an alarm")], ["SW0100"])
        agent.panel("reset")
        self.assertEqual([one["code"] for one in agent.status()["alarms"]], ["SW0100"], "as long as it is on")
        agent.panel("parameter-write", "off")
        agent.panel("reset")
        eventually(lambda: not agent.live()["alarms"], "off and reset")
        self.refused("other_profile", lambda: self.setter.post(f"/machines/{agent.id}/values/sheet", {
            "text": "# Headstock; profile gsk-2000tc; unit mm\nnumber,X\n1,1\n"}))
        self.refused("other_unit", lambda: self.setter.post(f"/machines/{agent.id}/values/sheet", {
            "text": "# Headstock; profile fanuc-0i-t; unit inch\nnumber,X\n1,1\n"}))
        sheet = self.setter.post(f"/machines/{agent.id}/values/sheet", {"text": "number\tX wear\n3\tabc\n999\t1\n"})
        self.assertEqual([row["problem"] for row in sheet["items"]], ["not_a_number", "bad_place"])
        agent.process.kill9()
        eventually(lambda: not agent.live()["connected"], "gone")
        refusal = self.refused("machine_refused", lambda: self.write(agent, WEAR, 0.02))
        self.assertEqual(refusal.reason, "not_connected", "nothing waits to be written later")

    def test_compare_copy_snapshot_restore(self):
        one, two = self.agent("Lathe 1"), self.agent("Lathe 2")
        sheet = self.setter.post(f"/machines/{one.id}/values/sheet", {
            "text": "number\tX\tX wear\tZ\tR\ttip\n1\t-112,5\t0,01\t-80\t0,8\t3\n2\t-100\t\t-75,25\t0,4\t3\n"})
        done = self.setter.post(f"/machines/{one.id}/values", {"origin": "import", "values": [
            {key: row[key] for key in ("what", "before", "after")} for row in sheet["items"]]})
        self.assertEqual(done["state"], "done", done)
        eventually(lambda: sum(what.startswith("tool/") for what in self.page(one)["values"]) == 9, "nine values")
        kept = self.setter.post(f"/machines/{one.id}/snapshots", {"name": "first set"})
        difference = self.shop.admin.get(f"/machines/{two.id}/values/difference", kind="offsets", machine=one.id)["items"]
        self.assertEqual(len(difference), 9)
        copied = self.setter.post(f"/machines/{two.id}/values", {"origin": "copy", "values": difference})
        self.assertEqual(copied["state"], "done")
        self.assertEqual(self.shop.admin.get(f"/machines/{two.id}/values/difference", kind="offsets", machine=one.id)["items"], [])
        moment = int(time.time() * 1000)
        time.sleep(0.01)   # the next change is later than this moment
        self.write(one, "tool/1/geometry/X", -111)
        eventually(lambda: self.value(one, "tool/1/geometry/X") == -111, "changed")
        for source in ({"at": moment}, {"snapshot": kept["id"]}):
            back = self.shop.admin.get(f"/machines/{one.id}/values/difference", kind="offsets", **source)["items"]
            self.assertEqual([(row["what"], row["before"], row["after"]) for row in back],
                             [("tool/1/geometry/X", -111, -112.5)])
        restored = self.setter.post(f"/machines/{one.id}/values", {"origin": "restore", "values": back})
        self.assertEqual(restored["state"], "done")
        eventually(lambda: self.value(one, "tool/1/geometry/X") == -112.5, "restored")
        self.assertEqual(self.history(one, "tool/1/geometry/X")[0]["origin"], "restore")

    def test_command_line(self):
        agent = self.agent()
        session = os.path.join(self.shop.folder, "session")

        def headstock(*words, status=0, text=None):
            done = subprocess.run([program("headstock"), "--session", session, "--lang", "en", *words], input=text,
                                  capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, status, done.stdout + done.stderr)
            return done.stdout

        headstock("login", "--server", self.setter.base, "--user", "wang", "--password-file", "-", text="correct horse 7\n")
        self.assertIn("written and read back", headstock("offsets", "set", "Lathe 1", WEAR, "+0.02", "--why", "measured"))
        eventually(lambda: self.value(agent, WEAR) == 0.02, "written")
        exported = headstock("offsets", "export", "Lathe 1")
        self.assertIn("number,X,X wear,Z,Z wear,R,R wear,tip", exported)
        self.assertIn("\n3,0,0.02,0,0,0,0,0\n", exported)
        changed = exported.replace("\n3,0,0.02,", "\n3,0,0.03,")
        headstock("offsets", "import", "Lathe 1", "-", text=changed)
        self.assertEqual(self.value(agent, WEAR), 0.02, "without --yes it is only shown")
        headstock("offsets", "import", "Lathe 1", "-", "--yes", text=changed)
        eventually(lambda: self.value(agent, WEAR) == 0.03, "imported")
        headstock("offsets", "import", "Lathe 1", "-", "--yes", text=changed.replace("0.03", "many"), status=2)
        self.assertIn("waits for a second person", headstock("offsets", "set", "Lathe 1", WEAR, "1"))
        self.assertIn(WEAR, headstock("offsets", "requests"))
        self.assertIn("import", headstock("offsets", "history", "Lathe 1", WEAR))
        self.assertIn("written and read back", headstock("variables", "set", "Lathe 1", "variable/500", "2.5"))
        headstock("parameters", "set", "Lathe 1", "parameter/6713", "5", status=2)
        self.assertIn("identical", headstock("recount"))

    def test_tool_life_is_carried_once_and_a_run_it_does_not_last_for_is_refused(self):
        agent = self.agent()
        agent.panel("parameter-write", "on")
        agent.panel("mode", "mdi")
        done = self.setter.post(f"/machines/{agent.id}/values", {"values": [
            {"what": "parameter/8132#0", "before": None, "after": 1}]})
        self.assertEqual(done["state"], "done")
        agent.panel("parameter-write", "off")
        agent.panel("reset")
        group = [("unit", 0), ("life", 3), ("tool/0", 1), ("offset/0", 1)]
        done = self.setter.post(f"/machines/{agent.id}/values", {"values": [
            {"what": f"tool_life/1/{field}", "before": None, "after": value} for field, value in group]})
        self.assertEqual(done["state"], "done", done)
        eventually(lambda: self.shop.admin.get("/tool-life")["items"], "the group is seen")
        agent.panel("mode", "memory")
        self.make_resident(agent, "O0020", "O20\nG21 G98\nT0199\nG00 X40. Z2.\nG01 Z0. F3000.\nG00 X50. Z10.\nM30\n%\n")
        agent.panel("select", "O0020")
        for run in (1, 2, 3):
            self.assertEqual(self.shop.admin.post(f"/machines/{agent.id}/select", {"name": "O0020"})["warnings"], [])
            agent.panel("select", "O0020")
            agent.panel("start")
            eventually(lambda: agent.status()["parts"]["count"] == run and agent.status()["state"] == "idle", "a part")
            if run == 2:
                agent.process.kill9()
                agent.start()
            eventually(lambda: self.shop.admin.get("/tool-life")["items"][0]["tools"][0]["used"] == run, "counted once")
        self.assertTrue(self.shop.admin.get("/tool-life")["items"][0]["change_due"])
        self.refused("tool_life_short", lambda: self.shop.admin.post(f"/machines/{agent.id}/select", {"name": "O0020"}))
        self.setter.call("PATCH", "/tool-life", {"short_life": "warn"})
        warned = self.shop.admin.post(f"/machines/{agent.id}/select", {"name": "O0020"})
        self.assertEqual(warned["warnings"], [{"group": 1, "unit": "uses", "need": 1, "left": 0}])
        used = self.history(agent, "tool_life/1/used/0")
        self.assertEqual([(row["before"], row["after"]) for row in reversed(used)], [(0, 1), (1, 2), (2, 3)])

    def test_what_does_not_outlive_power_is_told_by_the_machine(self):
        agent = self.agent()
        for what in ("variable/100", "variable/500"):
            done = self.setter.post(f"/machines/{agent.id}/values", {
                "values": [{"what": what, "before": self.page(agent)["values"].get(what), "after": 2.5}]})
            self.assertEqual(done["state"], "done", done)
        for restart in range(2):
            agent.process.kill9()
            agent.start()
            eventually(lambda: agent.status()["link"]["pending"] == 0, "its events are in")
            self.write(agent, WEAR, 0.02 + 0.01 * restart)   # all its data go to its disk, and to the server with a report
        # The second report that shows it gone finds nothing that was not told.
        agent.process.kill9()
        agent.start()
        self.write(agent, WEAR, 0.04)
        eventually(lambda: agent.status()["link"]["pending"] == 0, "its events are in")
        told = [(row["origin"], row["before"], row["after"]) for row in self.history(agent, "variable/100")]
        self.assertEqual(told, [("power_on", 2.5, None), ("person", None, 2.5)])
        self.assertEqual(self.history(agent, "variable/500")[0]["origin"], "person")
        self.assertNotIn("variable/100", self.page(agent)["values"])
        self.assertEqual(self.page(agent)["values"]["variable/500"], 2.5)

    def test_everybody_on_one_number_while_it_runs_and_dies(self):
        """A G10, a measured value, a browser edit and an import on one number, beside a running program and kill -9."""
        dice = random.Random(7)
        agent = self.agent()
        self.make_resident(agent, "O0010", G10.format(word="U0.001"))
        agent.panel("select", "O0010")
        stop = threading.Event()
        written, problems = [], []

        def quietly(work):
            try:
                return work()
            except (ApiError, OSError, AssertionError, subprocess.TimeoutExpired):
                return None     # refused, or nobody there: that is a fair answer

        def browser(who, origin, seed):
            mine = random.Random(seed)
            while not stop.is_set():
                try:
                    seen = self.value(agent, WEAR)
                    after = round(seen + mine.choice([-0.01, 0.01, 0.02]), 3)
                    done = who.post(f"/machines/{agent.id}/values", {"origin": origin, "values": [
                        {"what": WEAR, "before": seen, "after": after}]})
                    if done["state"] not in ("done", "unknown"):
                        problems.append(done)
                    written.append(done["id"])
                except (ApiError, OSError, http.client.HTTPException):
                    pass
                time.sleep(mine.uniform(0.01, 0.08))

        people = [threading.Thread(target=browser, args=arguments) for arguments in
                  ((self.setter, "person", 1), (self.second, "import", 2))]
        for one in people:
            one.start()
        try:
            for round_ in range(14):
                quietly(lambda: agent.panel("start"))
                until = time.monotonic() + dice.uniform(0.2, 0.7)
                while time.monotonic() < until:
                    quietly(lambda: agent.panel("measured", f"{WEAR}+=0.002"))
                victim = dice.choice(["agent", "server", "neither"])
                if victim == "agent":
                    agent.process.kill9()
                    agent.start(wait=False)
                elif victim == "server":
                    self.shop.server.kill9()
                    self.shop.start_server()
                eventually(lambda: agent.status(), "panel answers")
        finally:
            stop.set()
            for one in people:
                one.join()
        eventually(lambda: agent.status()["state"] == "idle", "run over")
        eventually(lambda: agent.live()["connected"] and agent.status()["link"]["pending"] == 0, "all events are in")
        self.assertEqual(problems, [])
        last = self.on_machine(agent, WEAR)
        chain = list(reversed(self.history(agent, WEAR)))
        self.assertGreater(len(chain), 20, "much was written")
        self.assertEqual([row for row in chain if row["origin"] not in ("person", "import", "measurement", "G10")], [],
                         "nothing was found that no event told of")
        self.assertEqual({row["origin"] for row in chain}, {"person", "import", "measurement", "G10"}, "everybody wrote")
        for before, after in zip(chain, chain[1:]):
            self.assertAlmostEqual(before["after"], after["before"], 9, f"a change is missing: {before} {after}")
        self.assertAlmostEqual(chain[-1]["after"], last, 9, "history and machine agree")
        self.assertAlmostEqual(self.value(agent, WEAR), last, 9, "and what the server shows")
        # Every request ended, done ones are in the history exactly once, the others not at all.
        eventually(lambda: not self.shop.admin.get("/value-requests", machine=agent.id, open="1")["items"], "all requests settled")
        carried_out = [row["request"] for row in chain if row["request"]]
        self.assertEqual(len(carried_out), len(set(carried_out)), "no request twice")
        requests = self.shop.admin.get("/value-requests", machine=agent.id, limit=1000)["items"]
        self.assertEqual({one["id"] for one in requests if one["state"] == "done"}, set(carried_out))
