"""Where to begin, when to send, what lies in the machines, what they punched: a real server, a control on a pseudo-terminal."""
import csv
import io
import json
import os
import subprocess
import time
import unittest
from datetime import datetime, timedelta, timezone
from urllib.request import Request, urlopen

import parts
from serial_control import iso
from shop import Client, eventually, program
from test_dnc import DncTest

TWO_TOOLS = """%
O2001 (TWO TOOLS)
N10 G21 G17 G90 G94 G54
N20 T05 M06
N30 S2000 M03
N40 G00 X0. Y0. Z20.
N50 G01 Z-1. F1200.
N60 G00 Z20.
N70 T06 M06
N80 S1500 M03
N90 G00 X0. Y0. Z20.
N100 G01 Z-2. F300.
N110 X15.
N120 G00 Z20.
N130 M05
N140 M30
%
"""


class Records(DncTest):
    def in_seconds(self, seconds):
        return (datetime.now(timezone.utc) + timedelta(seconds=seconds)).strftime("%Y-%m-%dT%H:%M:%S.%fZ")[:-4] + "Z"

    def plan(self, plan_id):
        return next(p for p in self.api.get("/port-plans")["items"] if p["id"] == plan_id)

    def cli(self, *arguments, status=0):
        made = subprocess.run([program("headstock"), "--session", os.path.join(self.shop.folder, "session"), *arguments],
                              capture_output=True, text=True, check=False, env={**os.environ, "LC_ALL": "C"})
        self.assertEqual(made.returncode, status, made.stdout + made.stderr)
        return made.stdout

    def test_a_start_at_a_sequence_number_a_block_and_a_tool(self):
        control, wish = self.control(), self.released("O2001", TWO_TOOLS)
        port = self.port(control.device)
        lines = TWO_TOOLS.split("\n")
        by_number = self.api.post(f"/ports/{port}/restart", {**wish, "sequence": 110})
        self.assertIsNone(by_number["error"], by_number)
        self.assertEqual(lines[by_number["line"] - 1], "N110 X15.")
        self.assertEqual(by_number["text"], "N110 X15.")
        self.assertIn("S1500 M03", by_number["header"])
        self.assertIn("T6 M06", by_number["header"], "the tool that is in the spindle there")
        by_tool = self.api.post(f"/ports/{port}/restart", {**wish, "tool": 6})
        self.assertEqual(by_tool["text"], "N70 T06 M06")
        blocks = [line for line in lines if line.strip() and line.strip() != "%"]
        number = blocks.index("N110 X15.") + 1
        self.assertEqual(self.api.post(f"/ports/{port}/restart", {**wish, "block": number})["line"], by_number["line"])
        with self.assertRaisesRegex(Exception, "place_not_found"):
            self.api.post(f"/ports/{port}/restart", {**wish, "sequence": 4711})
        with self.assertRaisesRegex(Exception, "bad_request"):
            self.api.post(f"/ports/{port}/restart", {**wish, "sequence": 110, "tool": 6})
        sent = self.api.post(f"/ports/{port}/send", {**wish, "from_line": by_number["line"], "header": by_number["header"]})
        self.waiting(sent["id"], "waiting")
        control.start()
        done = self.ended(sent["id"])
        self.assertEqual(done["state"], "done")
        eventually(lambda: len(control.read) >= done["total"], "all read")
        self.assertEqual(bytes(control.read), iso(by_number["header"] + TWO_TOOLS[TWO_TOOLS.index("N110"):]))
        tail = self.api.get(f"/port-transfers/{sent['id']}/tail")
        self.assertTrue(tail["text"].endswith("M30\n%\n"), tail)
        self.assertEqual(tail["line"], len(lines) - 1)

    def test_a_plan_sends_when_its_time_has_come_and_the_control_asks(self):
        control, wish = self.control(), self.released()
        port = self.port(control.device)
        with self.assertRaisesRegex(Exception, "in_the_past"):
            self.api.post(f"/ports/{port}/plans", {**wish, "at": self.in_seconds(-5)})
        later = self.api.post(f"/ports/{port}/plans", {**wish, "at": self.in_seconds(3600)})
        soon = self.api.post(f"/ports/{port}/plans", {**wish, "at": self.in_seconds(1)})
        self.assertEqual(soon["state"], "planned")
        self.assertIsNone(self.api.get(f"/ports/{port}")["transfer"], "nothing before its time")
        eventually(lambda: self.plan(soon["id"])["transfer"], "its time has come")
        transfer = self.plan(soon["id"])["transfer"]
        self.waiting(transfer, "waiting")
        self.assertEqual(len(control.read), 0, "the clock alone sends nothing: the control must ask")
        control.start()
        self.assertEqual(self.ended(transfer)["state"], "done")
        eventually(lambda: len(control.read) >= len(parts.MILL), "all read")
        self.assertEqual(bytes(control.read), iso(parts.MILL))
        self.assertEqual(self.api.call("DELETE", f"/port-plans/{later['id']}")["state"], "cancelled")
        with self.assertRaisesRegex(Exception, "already_decided"):
            self.api.call("DELETE", f"/port-plans/{later['id']}")

    def test_a_control_that_does_not_ask_is_never_served_by_the_clock(self):
        control, wish = self.control(), self.released()
        port = self.port(control.device, settings={"protocol": "xon-xoff"})
        with self.assertRaisesRegex(Exception, "cannot_queue"):
            self.api.post(f"/ports/{port}/plans", {**wish, "at": self.in_seconds(60)})
        with self.assertRaisesRegex(Exception, "cannot_queue"):
            self.api.post(f"/ports/{port}/send", {**wish, "armed": True})

    def test_a_plan_survives_a_restart_of_the_server_and_its_permission_does_not_outlive_the_person(self):
        control, wish = self.control(), self.released()
        port = self.port(control.device)
        self.api.post("/users", {"user": "petra", "name": "Petra", "role": "operator", "password": "a good Passw0rd", "language": "en"})
        made = Client(self.api.base).sign_in("petra", "a good Passw0rd")
        made.post("/session/password", {"old": "a good Passw0rd", "new": "another Passw0rd"})
        kept = self.api.post(f"/ports/{port}/plans", {**wish, "at": self.in_seconds(6)})
        hers = made.post(f"/ports/{port}/plans", {**wish, "at": self.in_seconds(6)})
        user = next(u for u in self.api.get("/users")["items"] if u["user"] == "petra")
        self.api.call("PATCH", f"/users/{user['id']}", {"role": "viewer"})
        self.shop.server.kill9()
        self.shop.start_server()
        self.api = self.shop.admin
        eventually(lambda: self.plan(kept["id"])["ended"] and self.plan(hers["id"])["ended"], "both have come up")
        eventually(lambda: self.plan(kept["id"])["transfer"], "the one is sent")
        self.assertEqual((self.plan(hers["id"])["state"], self.plan(hers["id"])["reason"]), ("refused", "forbidden"))

    def test_the_census_and_machine_data(self):
        control, wish = self.control(), self.released()
        port = self.port(control.device, listens=True)
        eventually(lambda: self.api.get(f"/ports/{port}")["state"] == "listening", "listening")
        sent = self.api.post(f"/ports/{port}/send", wish)
        self.waiting(sent["id"], "waiting")
        control.start()
        self.assertEqual(self.ended(sent["id"])["state"], "done")
        control.reading = False
        found = self.api.get("/census")["items"]
        self.assertEqual([(e["machine_name"], e["name"], e["state"], e["proof"]) for e in found], [("Old mill", "O2001", "released", "sent")])
        eventually(lambda: self.api.get(f"/ports/{port}")["state"] == "listening", "listening again")
        control.say(b"\x12" + iso(parts.MILL.replace("F1200.", "F900.")) + b"\x14")
        eventually(lambda: self.api.get("/received")["items"], "received")
        changed = self.api.get(f"/census?machine={self.machine}")["items"][0]
        self.assertEqual((changed["state"], changed["proof"], changed["classes"]), ("changed", "punched", ["feed_speed"]))
        for depth in ("-1.25", "-1.5"):
            eventually(lambda: self.api.get(f"/ports/{port}")["transfer"] is None, "the port is free")
            control.say(b"\x12" + iso(f"%\nG10 G90 L10 P1 R120.5\nG10 G90 L11 P1 R{depth}\n%\n") + b"\x14")
            row = eventually(lambda: [r for r in self.api.get("/received?state=waiting")["items"] if r["kind"] == "tool_offsets"], "offsets")[0]
            self.api.post(f"/received/{row['id']}/accept", {"why": "after setting"})
        sets = self.api.get(f"/punched-data?machine={self.machine}&kind=tool_offsets")["items"]
        self.assertEqual([s["entries"] for s in sets], [2, 2])
        newest = self.api.get(f"/punched-data/{sets[0]['id']}")
        self.assertEqual(newest["values"], [{"item": "L10 P1 R", "value": "120.5"}, {"item": "L11 P1 R", "value": "-1.5"}])
        self.assertEqual(newest["changes"], [{"item": "L11 P1 R", "before": "-1.25", "after": "-1.5"}])
        self.assertEqual(self.api.get("/programs")["items"][0]["newest"]["number"], 1, "the library is untouched")
        page = self.api.get(f"/machines/{self.machine}/values")["values"]
        self.assertEqual((page["tool/1/geometry/Z"], page["tool/1/wear/Z"]), (120.5, -1.5), "the machine has what it has punched")
        told = self.api.get(f"/machines/{self.machine}/value-changes", what="tool/1/wear/Z")["items"]
        self.assertEqual([(c["before"], c["after"], c["origin"]) for c in told], [(-1.25, -1.5, "import"), (0, -1.25, "import")])

    def test_a_punch_of_a_machine_with_an_agent_is_written_only_when_asked_for(self):
        agent = self.shop.agent("Mill 2", "fanuc-0i-m").start()
        eventually(lambda: self.api.get(f"/machines/{agent.id}/values")["reported"], "the machine has told what it has")
        control = self.control()
        port = self.port(control.device, listens=True, machine=agent.id)

        def accepted(text, **wish):
            eventually(lambda: self.api.get(f"/ports/{port}")["state"] == "listening" and self.api.get(f"/ports/{port}")["transfer"] is None, "listening")
            control.say(b"\x12" + iso(text) + b"\x14")
            row = eventually(lambda: [r for r in self.api.get("/received?state=waiting")["items"] if r["kind"] == "tool_offsets"], "received")[0]
            return self.api.post(f"/received/{row['id']}/accept", {"why": "set up", **wish})["values"]

        def length():
            return self.api.get(f"/machines/{agent.id}/values")["values"].get("tool/1/geometry/Z", 0)

        punched = "%\nG10 G90 L10 P1 R120.5\nG10 G90 L11 P1 R0\n%\n"
        looked = accepted(punched)
        self.assertEqual((looked["differ"], looked["same"], looked["request"]), (1, 1, None))
        self.assertEqual(length(), 0, "nothing was written")
        written = accepted(punched, write=True)
        self.assertEqual((written["differ"], written["request_state"]), (1, "done"), written)
        eventually(lambda: length() == 120.5, "the machine has it")
        change = eventually(lambda: self.api.get(f"/machines/{agent.id}/value-changes", what="tool/1/geometry/Z")["items"], "history")[0]
        self.assertEqual((change["origin"], change["request"]), ("import", written["request"]))
        agent.process.kill9()
        eventually(lambda: not agent.live()["connected"], "the server has noticed")
        self.assertEqual(accepted(punched.replace("120.5", "99."), write=True)["request_reason"], "not_connected")
        self.assertEqual(length(), 120.5)

    def test_the_log_and_the_command_line(self):
        control, wish = self.control(), self.released("O2001", TWO_TOOLS)
        port = self.port(control.device)
        sent = self.api.post(f"/ports/{port}/send", wish)
        self.waiting(sent["id"], "waiting")
        control.start()
        done = self.ended(sent["id"])
        request = Request(f"{self.shop.admin.base}/api/v1/transfer-log", headers={"Authorization": f"Bearer {self.api.token}"})
        with urlopen(request, timeout=10) as answer:
            self.assertIn("text/csv", answer.headers["Content-Type"])
            rows = list(csv.DictReader(io.StringIO(answer.read().decode("utf-8-sig"))))
        self.assertEqual(len(rows), 1)
        row = rows[0]
        self.assertEqual((row["port"], row["machine"], row["name"], row["outcome"], row["sha256"], row["line_sha256"], int(row["bytes"])),
                         ("Line 1", "Old mill", "O2001", "done", done["sha256"], done["wire_sha256"], done["bytes"]))
        self.assertGreater(float(row["seconds"]), 0)
        user, password = self.shop.administrator()
        kept = os.path.join(self.shop.folder, "password")
        with open(kept, "w", encoding="utf-8") as file:
            file.write(password + "\n")
        self.cli("login", "--server", self.api.base, "--user", user, "--password-file", kept)
        self.assertIn("O2001", self.cli("ports", "census"))
        self.assertEqual(len(list(csv.reader(io.StringIO(self.cli("ports", "log"))))), 2)
        self.assertIn("last whole line", self.cli("ports", "tail", str(sent["id"])))
        self.assertEqual(json.loads(self.cli("--json", "ports", "certificate", str(sent["id"])))["id"], sent["id"])
        shown = subprocess.run([program("headstock"), "--session", os.path.join(self.shop.folder, "session"), "ports", "send", "Line 1", "O2001",
                                "--from-tool", "6"], capture_output=True, text=True, check=False)
        self.assertNotEqual(shown.returncode, 0)
        self.assertIn("N70 T06 M06", shown.stderr)
        self.assertIn("nothing was sent", shown.stderr)
        made = self.cli("ports", "send", "Line 1", "O2001", "--at", self.in_seconds(3000))
        self.assertIn("O2001", made)
        listed = json.loads(self.cli("--json", "ports", "plans"))
        self.cli("ports", "unplan", str(listed[0]["id"]))
        self.assertEqual(self.api.get("/port-plans")["items"][0]["state"], "cancelled")

    def test_a_machine_with_an_agent_is_a_port_like_the_others(self):
        agent = self.shop.agent("Mill 2", "fanuc-0i-m").start()
        port = self.api.post("/ports", {"name": "Mill", "address": f"agent:{agent.id}"})
        self.assertEqual((port["kind"], port["machine"]), ("agent", agent.id))
        eventually(lambda: self.api.get(f"/ports/{port['id']}")["state"] == "listening", "connected")
        made = self.shop.upload("O2001", parts.MILL)
        wish = {"program": made["program"]["id"], "revision": made["revision"]["number"]}
        self.shop.release(wish["program"], wish["revision"], agent)
        sent = self.api.post(f"/ports/{port['id']}/send", wish)
        self.assertEqual(sent["kind"], "send")
        eventually(lambda: self.api.get(f"/transfers/{sent['id']}")["state"] == "done", "sent")
        dripped = self.api.post(f"/ports/{port['id']}/send", {**wish, "drip": True})
        eventually(lambda: (self.api.get(f"/ports/{port['id']}")["transfer"] or {}).get("id") == dripped["id"], "under way")
        with self.assertRaisesRegex(Exception, "not_for_agents"):
            self.api.post(f"/ports/{port['id']}/pause")
        self.api.post(f"/ports/{port['id']}/cancel")
        eventually(lambda: self.api.get(f"/transfers/{dripped['id']}")["state"] == "cancelled", "cancelled")
        self.assertIsNone(self.api.get(f"/ports/{port['id']}")["transfer"])
        self.assertIn("O2001", [e["name"] for e in self.api.get(f"/census?machine={agent.id}")["items"]])


if __name__ == "__main__":
    unittest.main()
