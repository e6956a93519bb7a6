"""DNC over serial lines: a real server, a control on a pseudo-terminal, serial-device servers of others."""
import hashlib
import os
import shutil
import socket
import subprocess
import unittest

import parts
from serial_control import Control, iso
from shop import ShopTest, eventually, free_port, program

FAST = {"line": "115200-8-N-2-software", "after_stop": 64}


class DncTest(ShopTest):
    def setUp(self):
        super().setUp()
        self.shop.start_server()
        self.api = self.shop.admin
        self.machine = self.api.post("/machines", {"name": "Old mill", "profile": "fanuc-0i-m"})["id"]

    def control(self, seed=1):
        made = Control(seed)
        self.addCleanup(made.close)
        return made

    def port(self, address, **fields):
        settings = {"protocol": "dc1-dc4", **FAST, **fields.pop("settings", {})}
        return self.api.post("/ports", {"name": "Line 1", "address": address, "machine": self.machine, "settings": settings, **fields})["id"]

    def released(self, name="O2001", text=parts.MILL):
        made = self.shop.upload(name, text)
        program_id, revision = made["program"]["id"], made["revision"]["number"]
        self.api.post(f"/programs/{program_id}/revisions/{revision}/check", {"machine": self.machine})
        eventually(lambda: self.api.get(f"/programs/{program_id}/revisions/{revision}/checks")["items"], "checked")
        self.api.post(f"/programs/{program_id}/revisions/{revision}/release", {"why": "test"})
        return {"program": program_id, "revision": revision}

    def transfer(self, transfer_id):
        return next(t for t in self.api.get("/port-transfers")["items"] if t["id"] == transfer_id)

    def ended(self, transfer_id):
        return eventually(lambda: (lambda t: t if t["ended"] else None)(self.transfer(transfer_id)), "transfer ended")

    def waiting(self, transfer_id, state):
        eventually(lambda: self.transfer(transfer_id)["state"] == state, state)


class Sending(DncTest):
    def test_a_program_reaches_the_control_exactly_and_has_a_certificate(self):
        control, wish = self.control(), self.released()
        port = self.port(control.device)
        for _ in range(3):
            sent = self.api.post(f"/ports/{port}/send", wish)
            self.waiting(sent["id"], "waiting")
            control.start()
            done = self.ended(sent["id"])
            self.assertEqual(done["state"], "done", done)
            eventually(lambda: len(control.read) >= done["total"], "all read")
            self.assertEqual(bytes(control.read), iso(parts.MILL))
            self.assertEqual(done["wire_sha256"], hashlib.sha256(bytes(control.read)).hexdigest())
            self.assertEqual(done["bytes"], len(control.read))
            self.assertEqual(done["revision"], wish["revision"])
            control.reading = False
        monitor = self.api.get(f"/ports/{port}")
        self.assertEqual(monitor["transfer"], None)

    def test_only_what_is_released_and_only_one_at_a_time(self):
        control = self.control()
        port = self.port(control.device)
        made = self.shop.upload("O2001", parts.MILL)
        wish = {"program": made["program"]["id"], "revision": made["revision"]["number"]}
        with self.assertRaisesRegex(Exception, "not_released"):
            self.api.post(f"/ports/{port}/send", wish)
        wish = self.released()
        sent = self.api.post(f"/ports/{port}/send", wish)
        with self.assertRaisesRegex(Exception, "port_busy"):
            self.api.post(f"/ports/{port}/send", wish)
        queued = self.api.post(f"/ports/{port}/send", {**wish, "queue": True})
        self.waiting(sent["id"], "waiting")
        control.start()
        self.assertEqual(self.ended(sent["id"])["state"], "done")
        self.waiting(queued["id"], "waiting")
        self.api.post(f"/ports/{port}/cancel")
        self.assertEqual(self.ended(queued["id"])["state"], "cancelled")

    def test_pause_resume_stop_and_a_restart_of_the_server(self):
        control = self.control()
        text = parts.MILL.replace("N50", "".join(f"N{i} G01 X{i % 50}.\n" for i in range(200, 1000)) + "N50", 1)
        wish = self.released("O2001", text)
        port = self.port(control.device, settings={"line": "9600-8-N-2-software"})
        sent = self.api.post(f"/ports/{port}/send", {**wish, "drip": True})
        self.waiting(sent["id"], "waiting")
        control.start()
        eventually(lambda: self.transfer(sent["id"])["bytes"] > 100, "on its way")
        self.api.post(f"/ports/{port}/pause")
        self.waiting(sent["id"], "paused")
        before = len(control.read)
        self.api.post(f"/ports/{port}/resume")
        eventually(lambda: len(control.read) > before + 50, "goes on")
        self.api.post(f"/ports/{port}/cancel")
        self.assertEqual(self.ended(sent["id"])["state"], "cancelled")
        self.assertTrue(iso(text).startswith(bytes(control.read)))
        again = self.api.post(f"/ports/{port}/send", wish)
        self.waiting(again["id"], "waiting")
        self.shop.server.kill9()
        self.shop.start_server()
        self.api = self.shop.admin
        ended = self.transfer(again["id"])
        self.assertEqual((ended["state"], ended["reason"]), ("failed", "server_restarted"))
        self.assertIsNone(self.api.get(f"/ports/{port}")["transfer"])

    def test_a_restart_header_is_shown_and_must_be_confirmed(self):
        control, wish = self.control(), self.released()
        port = self.port(control.device)
        asked = self.api.post(f"/ports/{port}/restart", {**wish, "line": 8})
        self.assertIsNone(asked["error"], asked)
        self.assertIn("S2000 M03", asked["header"])
        with self.assertRaisesRegex(Exception, "header_missing"):
            self.api.post(f"/ports/{port}/send", {**wish, "from_line": 8})
        sent = self.api.post(f"/ports/{port}/send", {**wish, "from_line": 8, "header": asked["header"]})
        self.waiting(sent["id"], "waiting")
        control.start()
        done = self.ended(sent["id"])
        eventually(lambda: len(control.read) >= done["total"], "all read")
        rest = parts.MILL[parts.MILL.index("N60"):]
        self.assertEqual(bytes(control.read), iso(asked["header"] + rest))

    def test_a_control_that_hangs_up(self):
        wish = self.released()
        with socket.create_server(("127.0.0.1", 0)) as listener:
            port = self.port(f"tcp://127.0.0.1:{listener.getsockname()[1]}")
            sent = self.api.post(f"/ports/{port}/send", wish)
            near, _ = listener.accept()
            self.waiting(sent["id"], "waiting")
            near.sendall(b"\x11")
            near.recv(10)
            near.close()
            ended = self.ended(sent["id"])
            self.assertEqual((ended["state"], ended["reason"]), ("failed", "disconnected"))
            again = self.api.post(f"/ports/{port}/send", wish)
            near, _ = listener.accept()
            near.sendall(b"\x11")
            read = b""
            while len(read) < again["total"]:
                read += near.recv(4096)
            self.assertEqual(read, iso(parts.MILL))
            self.assertEqual(self.ended(again["id"])["state"], "done")
            near.close()


class Receiving(DncTest):
    def test_a_punch_is_quarantined_and_accepted(self):
        control, wish = self.control(), self.released()
        port = self.port(control.device, listens=True)
        eventually(lambda: self.api.get(f"/ports/{port}")["state"] == "listening", "listening")
        changed = parts.MILL.replace("F1200.", "F900.")
        control.say(b"\x12" + iso(changed) + b"\x14")
        row = eventually(lambda: self.api.get("/received")["items"], "received")[0]
        self.assertEqual((row["name"], row["state"], row["classes"]), ("O2001", "waiting", ["feed_speed"]))
        self.assertEqual(len(self.api.get(f"/programs/{wish['program']}/revisions")["items"]), 1)
        difference = self.api.get(f"/received/{row['id']}/diff")
        self.assertEqual(difference["changed"], 1)
        self.api.post(f"/received/{row['id']}/accept", {"why": "slower is right"})
        newest = self.api.get(f"/programs/{wish['program']}/revisions")["items"][0]
        self.assertEqual(newest["origin"], f"machine:{self.machine}")
        self.assertIsNone(newest["released"])

    def test_noise_and_parity_change_nothing(self):
        control = self.control()
        port = self.port(control.device, listens=True)
        eventually(lambda: self.api.get(f"/ports/{port}")["state"] == "listening", "listening")
        control.say(b"\x12" + iso("%\nO1\nG0X") + b"\x31" + iso("\nM30\n%\n") + b"\x14")
        row = eventually(lambda: self.api.get("/port-transfers")["items"], "a record")[0]
        self.assertEqual((row["state"], row["reason"]), ("failed", "punch_parity"))
        self.assertEqual(self.api.get("/received")["items"], [])

    def test_the_control_asks_for_a_program(self):
        control, wish = self.control(), self.released()
        port = self.port(control.device, listens=True, rules=[{"pattern": "(GET=*)", "action": "send", "name": "O*"}])
        eventually(lambda: self.api.get(f"/ports/{port}")["state"] == "listening", "listening")
        control.say(b"\x12" + iso("%\nO0001(GET=2001)\nM30\n%\n") + b"\x14")
        eventually(lambda: (self.api.get(f"/ports/{port}")["transfer"] or {}).get("kind") == "answer", "the answer waits")
        control.start()
        eventually(lambda: len(control.read) >= len(parts.MILL), "answered")
        self.assertEqual(bytes(control.read), iso(parts.MILL))
        self.assertEqual(self.api.get("/received")["items"], [], "a request is not a program")
        control.say(b"\x12" + iso("%\nO0001(GET=9999)\nM30\n%\n") + b"\x14")
        refused = eventually(lambda: [t for t in self.api.get("/port-transfers")["items"] if t["reason"] == "not_found"], "refused")
        self.assertEqual(refused[0]["kind"], "answer")


    def test_the_control_asks_for_the_list(self):
        control = self.control()
        self.released()
        self.shop.upload("O4711", parts.MILL.replace("O2001", "O4711"))   # not released: not offered
        port = self.port(control.device, listens=True, rules=[{"pattern": "(LIST)", "action": "list", "name": "O8000"}])
        eventually(lambda: self.api.get(f"/ports/{port}")["state"] == "listening", "listening")
        control.say(b"\x12" + iso("%\nO0001(LIST)\nM30\n%\n") + b"\x14")
        answer = eventually(lambda: (lambda now: now if now and now["kind"] == "answer" else None)(self.api.get(f"/ports/{port}")["transfer"]), "the answer waits")
        control.start()
        self.assertEqual(self.ended(answer["id"])["state"], "done")
        eventually(lambda: len(control.read) >= answer["total"], "all read")
        self.assertEqual(bytes(control.read), iso("%\nO8000(PROGRAMS)\n(O2001)\nM30\n%\n"))

    def test_several_programs_in_one_punch_and_names_by_comment(self):
        control = self.control()
        port = self.port(control.device, listens=True, name_rule="comment", folder="/from-mill")
        eventually(lambda: self.api.get(f"/ports/{port}")["state"] == "listening", "listening")
        control.say(b"\x12" + iso("%\nO0001(FLANGE)\nG00 X1.\nM30\nO0002\nM30\n:3(BOLT M8)\nM99\n%\n") + b"\x14")
        rows = eventually(lambda: (lambda items: items if len(items) == 3 else None)(self.api.get("/received")["items"]), "three pieces")
        self.assertEqual(sorted((r["name"], r["folder"], r["state"]) for r in rows),
                         [("BOLT M8", "/from-mill", "waiting"), ("FLANGE", "/from-mill", "waiting"), ("O0002", "/from-mill", "waiting")])
        flange = next(r for r in rows if r["name"] == "FLANGE")
        self.api.post(f"/received/{flange['id']}/reject", {"why": "not ours"})
        with self.assertRaisesRegex(Exception, "already_decided"):
            self.api.post(f"/received/{flange['id']}/accept", {"why": ""})
        self.assertEqual(self.api.get("/programs")["items"], [])


class Others(DncTest):
    """Peers that we did not write."""

    @unittest.skipUnless(shutil.which("ser2net") and shutil.which("socat"), "ser2net and socat are not installed")
    def test_ser2net_speaks_rfc2217(self):
        control, wish = self.control(), self.released()
        number = free_port()
        config = os.path.join(self.shop.folder, "ser2net.yaml")
        with open(config, "w", encoding="ascii") as file:
            file.write(f"connection: &line\n  accepter: telnet(rfc2217),tcp,127.0.0.1,{number}\n"
                       f"  connector: serialdev,{control.device},9600n81,local\n")
        peer = subprocess.Popen(["ser2net", "-n", "-d", "-c", config], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(lambda: (peer.kill(), peer.wait()))
        eventually(lambda: socket.create_connection(("127.0.0.1", number), 1).close() or True, "ser2net listens")
        port = self.port(f"rfc2217://127.0.0.1:{number}", settings={"line": "115200-8-N-1-software"})

        def sent_once():
            # ser2net frees its line a moment after the connection before was closed.
            made = self.api.post(f"/ports/{port}/send", wish)
            eventually(lambda: self.transfer(made["id"])["ended"] or self.api.get(f"/ports/{port}")["state"] == "busy", "open")
            if self.transfer(made["id"])["ended"]:
                return None
            return made

        made = eventually(sent_once, "a connection")
        control.start()
        done = self.ended(made["id"])
        self.assertEqual(done["state"], "done", done)
        eventually(lambda: len(control.read) >= done["total"], "all read")
        self.assertEqual(bytes(control.read), iso(parts.MILL))

    @unittest.skipUnless(shutil.which("socat"), "socat is not installed")
    def test_socat_and_the_command_line(self):
        control = self.control()
        number = free_port()
        peer = subprocess.Popen(["socat", f"TCP-LISTEN:{number},bind=127.0.0.1,reuseaddr", f"{control.device},raw,echo=0"])
        self.addCleanup(lambda: (peer.kill(), peer.wait()))
        path = os.path.join(self.shop.folder, "part.nc")
        with open(path, "w", encoding="ascii") as file:
            file.write(parts.MILL)

        def listening():
            with open("/proc/net/tcp", encoding="ascii") as table:
                return f":{number:04X} " in table.read()

        eventually(listening, "socat listens")
        sender = subprocess.Popen([program("headstock"), "dnc", "send", "--port", f"tcp://127.0.0.1:{number}", "--line",
                                   "115200-8-N-2-software", path], stderr=subprocess.PIPE, text=True)
        self.assertIn("waiting", sender.stderr.readline())
        control.start()
        eventually(lambda: len(control.read) >= len(parts.MILL), "all read")
        self.assertEqual(bytes(control.read), iso(parts.MILL))
        self.assertEqual(sender.wait(60), 0)
        sender.stderr.close()

    def test_tape_codes_there_and_back(self):
        def convert(source, target, data):
            return subprocess.run([program("headstock"), "convert-tape", "--from", source, "--to", target, "-"], input=data,
                                  capture_output=True, check=True).stdout

        tape = convert("ascii", "iso", parts.MILL.encode())
        self.assertEqual(tape, iso(parts.MILL))
        eia = convert("iso", "eia", tape)
        self.assertNotEqual(eia, tape)
        self.assertEqual(convert("eia", "iso", eia), tape)
        bad = subprocess.run([program("headstock"), "convert-tape", "--from", "ascii", "--to", "eia", "-"], input=b"#1=2\n",
                             capture_output=True, check=False)
        self.assertEqual(bad.returncode, 2)
        self.assertIn(b"line 1, column 1", bad.stderr)


if __name__ == "__main__":
    unittest.main()
