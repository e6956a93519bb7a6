"""A port and all that goes over it, from the command line alone."""
import contextlib
import csv
import io
import json
import os
import socket
import subprocess
import threading
import unittest

import parts
from serial_control import iso
from shop import eventually, program
from test_dnc import DncTest


class Plug:
    """A plug that joins RXD and TXD: what comes goes back."""

    def __init__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"tcp://127.0.0.1:{self.listener.getsockname()[1]}"
        self.wrong = False
        threading.Thread(target=self.run, daemon=True).start()

    def run(self):
        while True:
            try:
                peer, _ = self.listener.accept()
            except OSError:
                return
            with peer, contextlib.suppress(OSError):   # the port may be closed on what is on its way back
                while piece := peer.recv(256):
                    peer.sendall(bytes(len(piece)) if self.wrong else piece)

    def close(self):
        self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()


class CommandLine(DncTest):
    def setUp(self):
        super().setUp()
        user, password = self.shop.administrator()
        kept = os.path.join(self.shop.folder, "password")
        with open(kept, "w", encoding="utf-8") as file:
            file.write(password + "\n")
        self.cli("login", "--server", self.api.base, "--user", user, "--password-file", kept)

    def command(self, *arguments):
        return [program("headstock"), "--session", os.path.join(self.shop.folder, "session"), *arguments]

    def cli(self, *arguments, status=0):
        made = subprocess.run(self.command(*arguments), capture_output=True, text=True, check=False, env={**os.environ, "LC_ALL": "C"})
        self.assertEqual(made.returncode, status, made.stdout + made.stderr)
        return made.stdout + made.stderr

    def test_a_port_is_added_tried_changed_and_removed(self):
        plug = Plug()
        self.addCleanup(plug.close)
        self.assertIn("address", self.cli("ports", "add", "Line 1", "--address", "/etc/passwd", "--protocol", "dc1-dc4", status=2))
        self.cli("ports", "add", "Line 1", "--address", plug.address, "--machine", "Old mill", "--protocol", "dc1-dc4",
                 "--line", "38400-8-N-2-software", "--rule", "(GET=*):O*", "--rule", "(LIST):O9999", "--name-rule", "comment")
        port = json.loads(self.cli("--json", "ports", "list"))[0]
        self.assertEqual((port["name"], port["machine"], port["name_rule"]), ("Line 1", self.machine, "comment"))
        self.assertEqual([(r["pattern"], r["action"], r["name"]) for r in port["rules"]], [("(GET=*)", "send", "O*"), ("(LIST)", "list", "O9999")])
        self.assertIn("ok", self.cli("ports", "test", "Line 1"))
        self.assertGreater(json.loads(self.cli("--json", "ports", "list"))[0]["measured"]["round_trip_us"], 0)
        plug.wrong = True
        self.assertIn("wrong_characters", self.cli("ports", "test", "Line 1", status=2))
        shown = self.cli("ports", "monitor", "Line 1")
        self.assertIn("opened", shown)
        self.assertIn("out", shown)
        self.cli("ports", "edit", "Line 1", "--line", "9600-7-E-2-software", "--folder", "/old")
        changed = json.loads(self.cli("--json", "ports", "list"))[0]
        self.assertEqual((changed["settings"]["line"], changed["folder"]), ("9600-7-E-2-software", "/old"))
        self.cli("ports", "remove", "Line 1")
        self.assertEqual(json.loads(self.cli("--json", "ports", "list")), [])

    def test_sending_waiting_for_the_end_and_the_log(self):
        control = self.control()
        self.released()
        self.port(control.device)
        sender = subprocess.Popen(self.command("ports", "send", "Line 1", "O2001", "--wait"), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(sender.kill)
        eventually(lambda: [t for t in self.api.get("/port-transfers")["items"] if t["state"] == "waiting"], "it waits for the control")
        control.start()
        told, _ = sender.communicate(timeout=60)
        self.assertEqual(sender.returncode, 0, told)
        self.assertIn("O2001 done", told)
        self.assertEqual(bytes(control.read), iso(parts.MILL))
        sent = json.loads(self.cli("--json", "ports", "history", "Line 1"))[0]
        rows = list(csv.DictReader(io.StringIO(self.cli("ports", "log").lstrip("\ufeff"))))
        self.assertEqual([(row["name"], row["outcome"], row["line_sha256"]) for row in rows], [("O2001", "done", sent["wire_sha256"])])
        self.assertIn(sent["wire_sha256"], self.cli("ports", "certificate", str(sent["id"])))

    def test_a_punch_is_listed_and_accepted_with_what_became_of_its_values(self):
        control = self.control()
        port = self.port(control.device, listens=True)
        eventually(lambda: self.api.get(f"/ports/{port}")["state"] == "listening", "listening")
        control.say(b"\x12" + iso("%\nG10 G90 L10 P1 R120.5\nG10 G90 L11 P1 R-.1\n%\n") + b"\x14")
        row = eventually(lambda: self.api.get("/received?state=waiting")["items"], "received")[0]
        self.assertIn("tool_offsets", self.cli("received"))
        self.assertIn("2 values written down", self.cli("received", "accept", str(row["id"]), "--why", "set up"))
        self.assertIn("tool_offsets", self.cli("ports", "data"))
        self.assertIn("decided already", self.cli("received", "reject", str(row["id"]), status=2))


if __name__ == "__main__":
    unittest.main()
