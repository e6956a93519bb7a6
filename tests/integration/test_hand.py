"""Moving by hand at the machine's own panel: steps, MDI, a jog that stops when nobody holds the button any more; and no
way to any of it from the network."""
import json
import os
import socket
import time

from shop import ApiError, ShopTest, eventually


class ByHand(ShopTest):
    def setUp(self):
        super().setUp()
        self.shop.start_server()
        self.agent = self.shop.agent("Mill by hand", "fanuc-0i-m").start()

    def position(self, axis):
        state = self.agent.status()
        return state["machine_position"][state["axes"].index(axis)]

    def ask(self, **request):
        """As a panel with real buttons does: a line to the socket in the agent's folder."""
        with socket.socket(socket.AF_UNIX) as line:
            line.connect(os.path.join(self.agent.folder, "panel.sock"))
            line.sendall(json.dumps(request).encode() + b"\n")
            return json.loads(line.makefile().readline())

    def test_steps_and_mdi(self):
        self.agent.panel("mode", "jog")
        start = self.position("X")
        self.agent.panel("step", "X2.5")
        eventually(lambda: abs(self.position("X") - start - 2.5) < 0.001, "X moved by its step")
        with self.assertRaises(OSError):
            self.agent.panel("step", "X99999")
        self.agent.panel("mode", "mdi")
        self.agent.panel("mdi", "G90 G94 G21 G01 X7. F3000.")
        self.agent.panel("start")
        eventually(lambda: abs(self.position("X") - 7) < 0.001, "the MDI block is carried out")

    def test_a_jog_nobody_holds_stops(self):
        self.agent.panel("mode", "jog")
        answer = self.ask(do="jog", axis="X", direction=1)
        self.assertTrue(answer["accepted"], answer)
        time.sleep(0.1)  # let it begin; what is judged is that it ends
        before = self.position("X")

        def stands():
            first = self.position("X")
            time.sleep(0.1)
            return self.position("X") == first
        eventually(stands, "the axis stops by itself")
        # 1000 mm/min for a quarter of a second, and the way to a standstill; much less than a jog that goes on.
        self.assertLess(self.position("X") - before, 100)
        self.agent.panel("jog", "X-0.5")
        eventually(stands, "and after a jog of half a second")

    def test_the_network_has_no_way_to_it(self):
        self.agent.arm()
        for action in ("jog", "step", "reference", "mdi", "set_axis_lock", "tap_retract", "retrace"):
            with self.assertRaises(ApiError) as refused:
                self.agent.command(action, 1)
            self.assertNotIn(refused.exception.status, (200, 201), action)
