"""What goes wrong on real lines: each ends with port, time and cause in its record, the library unchanged, and the port usable
again at once."""
import os
import socket
import time
import unittest

import parts
from device_server import BREAK, CTS, DSR, FRAMING, OVERRUN, PARITY, DeviceServer
from serial_control import iso
from shop import eventually
from test_dnc import DncTest

# HEADSTOCK_FLOOD_MB=2048 before a release.
FLOOD_MB = int(os.environ.get("HEADSTOCK_FLOOD_MB", "64"))
# Still on its way for seconds at 9600 baud, when a test that the computer keeps waiting spoils it.
LONG = parts.MILL.replace("O2001", "O2002").replace("N80 ", "".join(f"X{n % 20}. F1200.\n" for n in range(500)) + "N80 ")


class Bad(DncTest):
    def device_server(self):
        made = DeviceServer()
        self.addCleanup(made.close)
        return made

    def opened(self, server, port, wish):
        sent = self.api.post(f"/ports/{port}/send", wish)
        eventually(lambda: self.api.get(f"/ports/{port}")["state"] == "busy", "the line is open")
        return sent

    def long(self):
        return self.released("O2002", LONG)

    def usable_again(self, server, port, wish):
        """The same port carries a whole program right after the fault."""
        sent = self.opened(server, port, wish)
        server.read.clear()
        server.say(b"\x11")
        done = self.ended(sent["id"])
        self.assertEqual((done["state"], done["reason"]), ("done", None), done)
        eventually(lambda: len(server.read) >= done["total"], "all read")
        self.assertEqual(bytes(server.read), iso(parts.MILL))

    def library(self):
        return [(p["name"], p["newest"]["sha256"]) for p in self.api.get("/programs")["items"]]

    def test_every_fault_of_the_line_ends_the_transfer_by_name(self):
        server, wish, long = self.device_server(), self.released(), self.long()
        port = self.port(server.address, settings={"line": "9600-8-N-2-software"})
        before = self.library()
        for fault, reason in ((PARITY, "line_parity"), (FRAMING, "line_framing"), (OVERRUN, "line_overrun"), (BREAK, "line_break")):
            with self.subTest(reason):
                sent = self.opened(server, port, long)
                server.say(b"\x11")
                eventually(lambda: len(server.read) > 20, "on its way")
                server.line_error(fault)
                ended = self.ended(sent["id"])
                self.assertEqual((ended["state"], ended["reason"], ended["port"]), ("failed", reason, port))
                self.assertEqual(ended["figures"]["faults"][reason], 1)
                self.assertTrue(ended["created"] <= ended["ended"])
                self.assertIsNone(ended["wire_sha256"], "no certificate of what did not arrive")
                kinds = [entry["text"] for entry in self.api.get(f"/ports/{port}/monitor")["items"] if entry["kind"] == "fault"]
                self.assertIn(reason, kinds)
                self.usable_again(server, port, wish)
        self.assertEqual(self.library(), before)

    def test_noise_and_wrong_speed_in_a_punch_keep_nothing(self):
        server = self.device_server()
        self.released()
        port = self.port(server.address, listens=True)
        eventually(lambda: self.api.get(f"/ports/{port}")["state"] == "listening", "listening")
        before = self.library()
        for fault, reason in ((FRAMING, "line_framing"), (BREAK, "line_break"), (PARITY, "line_parity")):
            server.say(b"\x12" + iso("%\nO7777\nG0X1."))
            eventually(lambda: (self.api.get(f"/ports/{port}")["transfer"] or {}).get("bytes"), "it comes in")
            server.line_error(fault)
            server.say(iso("\nM30\n%\n") + b"\x14")
            newest = eventually(lambda: [t for t in self.api.get("/port-transfers")["items"] if t["reason"] == reason], reason)[0]
            self.assertEqual((newest["kind"], newest["state"], newest["port"]), ("receive", "failed", port))
        self.assertEqual(self.api.get("/received")["items"], [])
        self.assertEqual(self.library(), before)
        server.say(b"\x12" + iso("%\nO7777\nM30\n%\n") + b"\x14")
        eventually(lambda: [r["name"] for r in self.api.get("/received")["items"]] == ["O7777"], "the next one is taken")

    def test_a_control_that_never_starts_and_one_that_stops_and_dies(self):
        server, wish = self.device_server(), self.released()
        port = self.port(server.address, settings={"line": "9600-8-N-2-software", "start_limit_s": 1, "hold_limit_s": 1})
        silent = self.ended(self.opened(server, port, wish)["id"])
        self.assertEqual((silent["state"], silent["reason"], silent["bytes"]), ("failed", "no_start", 0))
        self.usable_again(server, port, wish)
        dead = self.opened(server, port, self.long())
        server.say(b"\x11")
        eventually(lambda: len(server.read) > 10, "on its way")
        server.say(b"\x93")
        ended = self.ended(dead["id"])
        self.assertEqual((ended["state"], ended["reason"]), ("failed", "held_too_long"))
        tail = self.api.get(f"/port-transfers/{dead['id']}/tail")
        self.assertIn(tail["text"], LONG)
        self.usable_again(server, port, wish)

    def test_a_drip_feed_may_be_held_longer_than_a_whole_program(self):
        server, wish = self.device_server(), self.released()
        port = self.port(server.address, settings={"line": "38400-8-N-2-software", "hold_limit_s": 1})
        sent = self.opened(server, port, {**wish, "drip": True})
        server.say(b"\x11\x13")
        self.waiting(sent["id"], "held")
        held = time.monotonic()
        eventually(lambda: time.monotonic() - held > 1.5, "longer than the limit of a whole program")
        self.assertEqual(self.transfer(sent["id"])["state"], "held")
        server.say(b"\x11")
        self.assertEqual(self.ended(sent["id"])["state"], "done")

    def test_cts_stops_and_continues(self):
        server = self.device_server()
        port = self.port(server.address, settings={"protocol": "rts-cts", "line": "9600-8-N-1-hardware", "code": "iso", "end_of_block": "lf", "after_stop": 16})
        sent = self.opened(server, port, self.long())
        eventually(lambda: len(server.read) > 20, "on its way")
        server.signals(DSR)
        self.waiting(sent["id"], "held")
        self.assertFalse(self.api.get(f"/ports/{port}")["signals"]["cts"])
        server.signals(DSR | CTS)
        done = self.ended(sent["id"])
        self.assertEqual(done["state"], "done", done)
        eventually(lambda: len(server.read) >= done["total"], "all read")
        self.assertEqual(bytes(server.read), iso(LONG))
        signals = [e["text"] for e in self.api.get(f"/ports/{port}/monitor?limit=1000")["items"] if e["kind"] == "signals"]
        self.assertTrue(any("CTS" in s for s in signals) and any("CTS" not in s for s in signals), signals)

    def test_a_disconnect_ends_the_permission_and_nothing_resumes_by_itself(self):
        server, wish = self.device_server(), self.released()
        port = self.port(server.address, listens=True)
        eventually(lambda: self.api.get(f"/ports/{port}")["state"] == "listening", "listening")
        sent = self.api.post(f"/ports/{port}/send", {**wish, "armed": True})
        queued = self.api.post(f"/ports/{port}/send", {**wish, "queue": True})
        self.waiting(sent["id"], "waiting")
        server.hang_up()
        self.assertEqual(self.ended(sent["id"])["reason"], "disconnected")
        self.assertEqual(self.ended(queued["id"])["reason"], "one_before_failed")
        eventually(lambda: server.connections >= 2 and self.api.get(f"/ports/{port}")["state"] == "listening", "the line is there again")
        server.say(b"\x11")
        monitor = eventually(lambda: [e for e in self.api.get(f"/ports/{port}/monitor")["items"] if "DC1" in e["text"]], "the control asks")
        self.assertTrue(monitor)
        self.assertIsNone(self.api.get(f"/ports/{port}")["transfer"])
        self.assertEqual(bytes(server.read), b"", "not one character")
        self.usable_again(server, port, wish)

    def test_a_punch_that_never_ends_and_one_that_is_far_too_long(self):
        with socket.create_server(("127.0.0.1", 0)) as listener:
            port = self.port(f"tcp://127.0.0.1:{listener.getsockname()[1]}", listens=True,
                             settings={"protocol": "xon-xoff", "code": "ascii", "most_bytes": 100_000, "punch_limit_s": 3, "quiet_ms": 500})
            peer, _ = listener.accept()
            self.addCleanup(peer.close)
            eventually(lambda: self.api.get(f"/ports/{port}")["state"] == "listening", "listening")
            peer.sendall(b"%\nO1\n")
            piece = b"G01 X1. (AND SO ON)\n" * 5_000
            for _ in range(FLOOD_MB * 10):  # as fast as it goes
                peer.sendall(piece)
            ended = eventually(lambda: [t for t in self.api.get("/port-transfers")["items"] if t["ended"]], "refused")
            self.assertEqual([t["reason"] for t in ended], ["too_large"], "one record, not one for every piece of it")
            self.assertLess(self.disk(), 20_000_000)

            came = []
            while not came:  # what comes before the line has been quiet belongs to what was refused
                time.sleep(1)
                peer.sendall(b"%\nO5555\nM30\n%\n")
                limit = time.monotonic() + 2
                while not came and time.monotonic() < limit:
                    came = [r for r in self.api.get("/received")["items"] if r["name"] == "O5555"]
            endless = time.monotonic() + 6
            peer.sendall(b"%\nO1\n")
            while time.monotonic() < endless and not [t for t in self.api.get("/port-transfers")["items"] if t["reason"] == "never_ends"]:
                peer.sendall(b"X1\n")
                time.sleep(0.02)
            eventually(lambda: [t for t in self.api.get("/port-transfers")["items"] if t["reason"] == "never_ends"], "never ends")
            self.assertEqual(self.api.get("/programs")["items"], [])

    def disk(self):
        return sum(os.path.getsize(os.path.join(folder, name)) for folder, _, names in os.walk(self.shop.folder) for name in names)

    def test_a_name_that_would_leave_its_folder(self):
        server = self.device_server()
        port = self.port(server.address, listens=True, folder="/from-lathe", name_rule="comment", settings={"protocol": "dc1-dc4"})
        eventually(lambda: self.api.get(f"/ports/{port}")["state"] == "listening", "listening")
        server.say(b"\x12" + iso("%\nO1(../../ETC/PASSWD)\nM30\n%\n") + b"\x14")
        row = eventually(lambda: self.api.get("/received")["items"], "received")[0]
        self.assertNotIn("/", row["name"])
        self.api.post(f"/received/{row['id']}/accept", {"why": ""})
        found = self.api.get("/programs")["items"]
        self.assertEqual([(p["folder"], p["name"]) for p in found], [("/from-lathe", row["name"])])


if __name__ == "__main__":
    unittest.main()
