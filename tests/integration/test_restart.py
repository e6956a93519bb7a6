"""The power fails in the middle of a part: the machine knows the block, nothing moves by itself, and the operator takes
the program up again from there."""
import contextlib
import json
import os
import shutil
import sqlite3
import tempfile

from shop import ShopTest, eventually

# The third block takes minutes at this feed: the power fails inside it, however fast or slow this computer is.
PART = "O1\nG90 G94 G21 G54\nN10 G00 X10. Y20. Z30.\nN20 G01 Z25. F3000.\nN30 Y220. F20.\nN40 Z30. F3000.\nM30\n%\n"


class PowerLoss(ShopTest):
    def kept(self):
        """What is on the machine's disk. The agent has its spool to itself, so this reads a copy, as a power loss leaves it."""
        with tempfile.TemporaryDirectory() as folder:
            copy = os.path.join(folder, "spool")
            for end in ("", "-wal"):
                shutil.copyfile(self.spool + end, copy + end)
            with contextlib.closing(sqlite3.connect(copy)) as disk:
                row = disk.execute("SELECT value FROM retained WHERE key = 'counters'").fetchone()
        return (json.loads(row[0]).get("breakpoint") or {}) if row else {}

    def test_a_part_is_taken_up_where_the_power_failed(self):
        self.shop.start_server()
        agent = self.shop.agent("Mill 1", "fanuc-0i-m").start()
        self.spool = next(os.path.join(agent.folder, name) for name in os.listdir(agent.folder)
                          if name.startswith("spool") and not name.endswith(("-wal", "-shm")))
        self.make_resident(agent, "O0001", PART)
        agent.panel("select", "O0001")
        agent.panel("start")
        eventually(lambda: self.kept().get("sequence") == 30, "the block is on the disk", 120)
        agent.process.kill9()
        agent.start(wait=False)
        status = eventually(agent.status, "the panel answers after kill -9")
        self.assertEqual(status["state"], "idle", "nothing may start by itself")
        self.assertEqual(status["breakpoint"]["sequence"], 30)
        before = status["machine_position"]

        agent.panel("restart", "broken")
        found = eventually(lambda: agent.status()["restart"], "the block is found")
        self.assertEqual(agent.status()["state"], "stopped")
        self.assertEqual(agent.status()["machine_position"], before, "the search moves nothing")
        axes = status["axes"]
        self.assertEqual([found["machine_position"][axes.index(name)] for name in "XYZ"], [10, 20, 25])

        agent.panel("start")
        y = axes.index("Y")
        eventually(lambda: agent.status()["sequence"] == 30 and agent.status()["machine_position"][y] > 20.2,
                   "the program goes on in that block, with the drives settled", 120)
        position = agent.status()["machine_position"]
        self.assertAlmostEqual(position[axes.index("X")], 10, delta=0.01)
        self.assertAlmostEqual(position[axes.index("Z")], 25, delta=0.01)
        agent.panel("reset")

    def test_another_program_is_not_taken_up(self):
        self.shop.start_server()
        agent = self.shop.agent("Mill 1", "fanuc-0i-m").start()
        self.make_resident(agent, "O0001", PART)
        agent.panel("select", "O0001")
        agent.panel("start")
        eventually(lambda: (agent.status()["breakpoint"] or {}).get("sequence") == 30, "in the third block", 120)
        agent.panel("reset")
        eventually(lambda: agent.status()["state"] == "idle", "stands")
        self.make_resident(agent, "O0002", PART.replace("O1", "O2"))
        agent.panel("select", "O0002")
        with self.assertRaises(OSError):
            agent.panel("restart", "broken")
        self.assertEqual(agent.status()["state"], "idle")
