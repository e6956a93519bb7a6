"""A machine fed by somebody else's DNC software over its own line: real pseudo-terminals and sockets, `headstock dnc
send`, socat and a bare script as the sender."""
import contextlib
import os
import shutil
import socket
import subprocess
import time
import tty
import unittest
import json
import tempfile

from shop import MACHINE_FILES, PATIENCE_S, ROOT, Process, eventually, free_port, program
from serial_control import iso

HEAD = "%\nO3001\nG21 G90 G94 G54\nG00 X0. Y0. Z10.\n"
TAIL = "G00 Z20.\nM30\n%\n"


def zigzag(blocks):
    lines = [f"N{i % 10000:04d} G01 X{i % 2 * 2.0:.3f} Y{i % 300 * 0.1:.3f} F6000.\n" for i in range(1, blocks + 1)]
    return HEAD + "".join(lines) + TAIL, {"X": blocks % 2 * 2.0, "Y": blocks % 300 * 0.1, "Z": 20.0}


class Machine:
    """An agent alone, without a server."""

    def __init__(self, case, dnc, profile="fanuc-0i-m", clock="fast"):
        self.folder = tempfile.mkdtemp(prefix="headstock-test-")
        case.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.process = Process([program("headstock-agent"), "--data", self.folder, "--server", "", "--clock", clock,
                                "--machine", os.path.join(ROOT, "deploy/machines", MACHINE_FILES[profile]),
                                "--dnc", dnc], os.path.join(self.folder, "agent.log"))
        case.addCleanup(self.process.kill9)
        eventually(self.status, "the agent answers at its panel")

    def panel(self, *words):
        done = subprocess.run([program("headstock-agent"), "panel", "--data", self.folder, *words], capture_output=True,
                              text=True, timeout=PATIENCE_S)
        if done.returncode:
            raise OSError(f"panel {words}: {done.stdout}{done.stderr}")
        return done.stdout

    def status(self):
        if not self.process.running():
            raise AssertionError(f"the agent ended: {self.process.text()}")
        return json.loads(self.panel("status"))

    def until(self, condition, what, patience_s=PATIENCE_S):
        return eventually(lambda: (lambda s: s if condition(s) else None)(self.status()), what, patience_s)

    def on(self):
        self.panel("dnc", "on")
        self.until(lambda s: s["dnc"]["open"], "the line is open")

    def codes(self):
        return [alarm["code"] for alarm in self.status()["alarms"]]

    def stands_at(self, place):
        return self.until(lambda s: all(abs(place[a] - p) < 1e-3 for a, p in zip(s["axes"], s["absolute"]) if a in place),
                          f"the axes stand at {place}")


class DncInput(unittest.TestCase):
    def crossed(self):
        """Two pseudo-terminals, each the far end of the other: a cable."""
        folder = tempfile.mkdtemp(prefix="headstock-cable-")
        self.addCleanup(shutil.rmtree, folder, ignore_errors=True)
        ends = [os.path.join(folder, name) for name in ("machine", "sender")]
        cable = subprocess.Popen(["socat", f"pty,raw,echo=0,link={ends[0]}", f"pty,raw,echo=0,link={ends[1]}"])
        self.addCleanup(cable.wait)
        self.addCleanup(cable.kill)
        eventually(lambda: all(os.path.exists(end) for end in ends), "the cable is there")
        return [os.path.realpath(end) for end in ends]

    def file(self, text):
        handle, path = tempfile.mkstemp(suffix=".nc")
        self.addCleanup(os.unlink, path)
        with os.fdopen(handle, "w", encoding="ascii", newline="\n") as out:
            out.write(text)
        return path

    def run_to_its_end(self, machine, place, parts=1):
        machine.panel("start")

        def executed(status):
            # Its clock is faster than any line: whenever the data run out it holds, and a person goes on, also when
            # the rest has already been taken out of the buffer.
            if status["state"] == "hold":
                with contextlib.suppress(OSError):   # it may have gone on meanwhile
                    machine.panel("start")
            return status["parts"]["count"] == parts

        machine.until(executed, "the program was executed", 4 * PATIENCE_S)
        machine.stands_at(place)
        return machine.until(lambda s: s["dnc"]["state"] == "ready", "drained, and ready for the next")["dnc"]["last"]

    def test_headstocks_own_sender_over_a_cable_two_programs_one_after_the_other(self):
        near, far = self.crossed()
        machine = Machine(self, f"{near},line=115200-8-N-1-software,code=iso")
        machine.on()
        for turn, blocks in ((1, 400), (2, 201)):
            text, place = zigzag(blocks)
            log = os.path.join(machine.folder, f"sender-{turn}.log")
            sender = Process([program("headstock"), "dnc", "send", "--port", far, "--line", "115200-8-N-1-software",
                              "--protocol", "dc1-dc4", self.file(text)], log)
            self.addCleanup(sender.kill9)
            eventually(lambda: "waiting" in sender.text(), "the sender waits to be asked")
            last = self.run_to_its_end(machine, place, turn)
            self.assertEqual(last["outcome"], "drained")
            self.assertEqual(sender.child.wait(PATIENCE_S), 0, sender.text())

    def test_socat_into_a_listening_port_with_the_handshake_of_tcp(self):
        port = free_port()
        machine = Machine(self, f"listen://127.0.0.1:{port},line=9600-8-N-1-hardware,code=ascii")
        machine.on()
        text, place = zigzag(20_000)
        sender = subprocess.Popen(["socat", "-u", f"FILE:{self.file(text)}", f"TCP:127.0.0.1:{port}"])
        self.addCleanup(sender.wait)
        self.addCleanup(sender.kill)
        last = self.run_to_its_end(machine, place)
        self.assertEqual(last["outcome"], "drained")
        self.assertGreater(last["bytes"], len(text) - 10)

    def peer(self, port):
        made = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S)
        self.addCleanup(made.close)
        return made

    def listening(self, **more):
        port = free_port()
        machine = Machine(self, f"listen://127.0.0.1:{port},line=9600-8-N-1-hardware,code=ascii", **more)
        machine.on()
        return machine, port

    def test_a_character_of_wrong_parity_is_the_th_alarm_behind_the_last_good_block(self):
        near, far = self.crossed()
        machine = Machine(self, f"{near},line=9600-8-N-1-software,code=iso")
        machine.on()
        line = os.open(far, os.O_RDWR | os.O_NOCTTY)
        self.addCleanup(os.close, line)
        tty.setraw(line)
        machine.panel("start")
        self.assertEqual(os.read(line, 1), b"\x11", "asks with DC1")
        good = HEAD + "G01 X5. F3000.\nX7.\n"
        os.write(line, iso(good) + iso("X") + bytes([iso("9")[0] ^ 0x80]) + iso(".\nX20.\n"))
        machine.until(lambda s: s["state"] == "alarm", "the alarm")
        self.assertEqual(machine.codes(), ["PS0001"])
        machine.stands_at({"X": 7.0, "Y": 0.0, "Z": 10.0})
        self.assertEqual(os.read(line, 1), b"\x93", "the sender is stopped")
        machine.panel("reset")
        seen = machine.until(lambda s: s["dnc"]["state"] == "off", "off: sender and machine start again together")
        self.assertEqual(seen["dnc"]["reason"], "th")
        with self.assertRaisesRegex(OSError, "."):
            machine.panel("start")

    def test_a_sender_that_dies_in_the_middle(self):
        machine, port = self.listening()
        peer = self.peer(port)
        machine.panel("start")
        peer.sendall((HEAD + "G01 X3. F3000.\nX4.\nX1").encode())
        peer.close()
        machine.until(lambda s: s["state"] == "alarm", "the alarm")
        self.assertEqual(machine.codes(), ["PS0086"])
        machine.stands_at({"X": 4.0, "Y": 0.0, "Z": 10.0})

    def test_data_that_run_out_are_a_hold_and_only_a_person_goes_on(self):
        machine, port = self.listening()
        peer = self.peer(port)
        machine.panel("start")
        peer.sendall((HEAD + "G01 X3. F3000.\n").encode())
        machine.until(lambda s: s["state"] == "hold", "feed hold")
        self.assertEqual(machine.codes(), ["DNC"])
        stands = machine.stands_at({"X": 3.0, "Y": 0.0, "Z": 10.0})["absolute"]   # what came whole is executed
        peer.sendall(("X4.\nX5.\n" + TAIL).encode())
        machine.until(lambda s: s["dnc"]["received"] > len(HEAD) + 20, "the rest is here")
        for _ in range(10):
            self.assertEqual(machine.status()["state"], "hold")
            for now, then in zip(machine.status()["absolute"], stands):   # measured: the drives settle
                self.assertAlmostEqual(now, then, places=2)
        machine.panel("start")
        machine.until(lambda s: s["parts"]["count"] == 1, "executed")
        machine.stands_at({"X": 5.0, "Z": 20.0})
        self.assertEqual(machine.codes(), [])

    def test_reset_in_the_middle_and_the_rest_is_never_executed(self):
        machine, port = self.listening()
        peer = self.peer(port)
        peer.setblocking(False)
        text, _ = zigzag(400_000)
        data, at = text.encode(), 0
        machine.panel("start")

        def push():
            nonlocal at
            try:
                at += peer.send(data[at:at + 65536])
            except OSError:
                pass
            return machine.status()["line"] or 0

        eventually(lambda: push() > 50, "it runs")
        machine.panel("reset")
        machine.until(lambda s: s["dnc"]["state"] == "off", "off")
        self.assertLess(at, len(data), "the sender was held")
        with self.assertRaises(OSError):
            machine.panel("start")
        machine.until(lambda s: s["state"] == "idle", "idle")
        peer.close()
        # Whoever switches it on again with the sender in the middle gets an alarm, not motion.
        place = machine.status()["absolute"]
        machine.on()
        again = self.peer(port)
        machine.panel("start")
        again.sendall(data[at:at + 1000])
        machine.until(lambda s: s["state"] == "alarm", "the alarm")
        self.assertEqual(machine.codes(), ["HS0041"])
        # Positions are those measured by the drives, which settle by less than an increment after the axes stand.
        for axis, (now, before) in enumerate(zip(machine.status()["absolute"], place, strict=True)):
            self.assertAlmostEqual(now, before, delta=0.001, msg=f"axis {axis}")

    def test_rules_of_a_program_that_is_fed(self):
        for block, code in (("GOTO 10", "PS0123"), ("WHILE [#1 LT 3] DO1", "PS0123"), ("M198 P1234", "PS0210")):
            machine, port = self.listening()
            peer = self.peer(port)
            machine.panel("start")
            peer.sendall((HEAD + block + "\n" + TAIL).encode())
            machine.until(lambda s: s["state"] == "alarm", block)
            self.assertEqual(machine.codes(), [code])

    def test_nothing_is_read_before_cycle_start_and_another_choice_ends_it(self):
        machine, port = self.listening()
        peer = self.peer(port)
        peer.sendall((HEAD + TAIL).encode())
        seen = machine.status()
        self.assertEqual((seen["state"], seen["dnc"]["state"], seen["dnc"]["received"]), ("idle", "ready", 0))
        machine.panel("load", self.file("O0007\nM30\n"))
        name = machine.status()["programs"][0]["name"]
        machine.panel("select", name)
        self.assertEqual(machine.status()["dnc"]["state"], "off")
        self.assertEqual(machine.status()["mode"], "memory")

    def test_a_line_that_is_not_there(self):
        machine = Machine(self, "/dev/headstock-no-such-line")
        machine.panel("dnc", "on")
        seen = machine.until(lambda s: s["dnc"]["reason"], "said")
        self.assertEqual(seen["dnc"]["reason"], "port_not_found")
        machine.panel("start")
        machine.until(lambda s: s["state"] == "alarm", "no line, no program")
        self.assertEqual(machine.codes(), ["PS0086"])


if __name__ == "__main__":
    unittest.main()
