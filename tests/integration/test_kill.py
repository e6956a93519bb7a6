"""kill -9 of server or agent at any moment, with parts being counted: none lost, none double."""
import random
import time

from shop import ShopTest, eventually

# Short, so that parts are counted all through the killing.
QUICK = "O1\nG21 G98\nG00 X40. Z2.\nG01 Z0. F3000.\nG00 X50. Z10.\nM30\n%\n"
KILLS = 50


class KillAnything(ShopTest):
    def test_fifty_kills_lose_no_part_and_double_none(self):
        dice = random.Random(20)
        self.shop.start_server()
        agent = self.shop.agent("Lathe 1", "fanuc-0i-t").start()
        self.make_resident(agent, "O0001", QUICK)
        agent.panel("select", "O0001")   # the operator has seen what was sent
        witnessed = 0   # parts the machine itself has shown as finished
        for kill in range(KILLS):
            made = witnessed
            while kill % 3 == 0 and witnessed == made:   # some kills come right behind a part, whatever the speed
                status = agent.status()
                witnessed = max(witnessed, status["parts"]["count"])
                if status["state"] == "idle" and witnessed == made:
                    agent.panel("start")
            # Anywhere in the cycle, the count's commit and the report to the server included.
            until = time.monotonic() + dice.uniform(0.0, 0.6)
            while time.monotonic() < until:
                status = agent.status()
                witnessed = max(witnessed, status["parts"]["count"])
                if status["state"] == "idle":
                    agent.panel("start")
            if dice.random() < 0.5:
                self.shop.server.kill9()
                self.shop.start_server()
            else:
                agent.process.kill9()
                agent.start(wait=False)
                status = eventually(agent.status, "agent's panel answers after kill -9")
                self.assertEqual(status["state"], "idle", "nothing may start by itself")
                self.assertFalse(status["remote_armed"], "arming ends with the process")
            self.assertGreaterEqual(eventually(agent.status, "panel")["parts"]["count"], witnessed,
                                    f"kill {kill}: a finished part was lost")
        eventually(lambda: agent.status()["state"] == "idle", "agent idle")
        count = agent.status()["parts"]["count"]
        self.assertGreaterEqual(count, KILLS // 3, "parts were really made while the killing went on")
        eventually(lambda: agent.live()["connected"] and agent.parts() == count, "server agrees with the machine")

        def all_events():
            rows = self.shop.admin.get("/parts", machine=agent.id, limit=1000)["items"]
            return rows if len(rows) == count else None

        rows = eventually(all_events, f"exactly {count} part events in the store")
        self.assertEqual(sorted(row["count"] for row in rows), list(range(1, count + 1)), "each part once")
