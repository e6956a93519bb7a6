#!/usr/bin/env python3
"""Parts made on many machines while agents, server and links are killed and cut: counted exactly, recounted the same.

    tests/integration/count_parts.py [--agents 20] [--parts 1000] [--trouble 200] [--seed 1]      about ten minutes

Each machine makes its share. In between, at random: kill -9 of an agent (restarted at once), a cut of its link, kill -9 of
the server. At the end the machines' own counters, the part events and the recount from raw events must say the same, every
run that began must have ended in the record, and no witness may disagree with another.
"""
import argparse
import random
import sys
import threading
import time

from shop import CuttingProxy, Shop, eventually

QUICK = "O1\nG21 G98\nG00 X40. Z2.\nG01 Z0. F6000.\nG00 X50. Z10.\nM30\n%\n"


class Machine:
    def __init__(self, shop, number, share, dice):
        self.shop, self.share, self.dice = shop, share, dice
        self.proxy = CuttingProxy(shop.agent_port)
        self.agent = shop.agent(f"Lathe {number}", "fanuc-0i-t", extra=["--clock", "fast"])
        self.agent.start(port=self.proxy.port)
        self.lock = threading.Lock()     # one at the agent's process at a time: restart or panel
        self.witnessed = 0               # parts its own panel has shown
        self.error = None

    def prepare(self, program_id):
        self.shop.send(program_id, 1, [self.agent])
        eventually(lambda: self.agent.panel("select", "O0001") is not None, "selected")

    def make(self):
        """Starts until the machine itself says that its share is made."""
        try:
            while self.witnessed < self.share:
                with self.lock:
                    status = eventually(self.agent.status, f"{self.agent.name}: panel answers")
                    count = status["parts"]["count"]
                    assert count >= self.witnessed, f"{self.agent.name}: {self.witnessed} parts were seen, now {count}"
                    self.witnessed = count
                    if status["state"] == "idle" and count < self.share:
                        try:
                            self.agent.panel("start")
                        except OSError:
                            pass
                time.sleep(0.005)
        except BaseException as problem:   # told by the main thread
            self.error = problem

    def kill(self):
        with self.lock:
            self.agent.process.kill9()
            self.agent.start(port=self.proxy.port, wait=False)
            eventually(self.agent.status, f"{self.agent.name} answers after kill -9")


def run(agents, parts, trouble, seed=1, say=print):
    """Returns the figures; raises AssertionError when anything is not exact."""
    dice = random.Random(seed)
    shop = Shop()
    machines = []
    try:
        shop.start_server()
        shares = [parts // agents + (i < parts % agents) for i in range(agents)]
        for number, share in enumerate(shares, 1):
            machines.append(Machine(shop, number, share, dice))
        made = shop.upload("O0001", QUICK)
        shop.release(made["program"]["id"], 1, machines[0].agent)
        for machine in machines:
            machine.prepare(made["program"]["id"])
        threads = [threading.Thread(target=machine.make, daemon=True) for machine in machines]
        for thread in threads:
            thread.start()
        kinds = {"agent killed": 0, "link cut": 0, "server killed": 0}
        for turn in range(trouble):
            # Spread over the work: the next trouble when its share of the parts is made.
            eventually(lambda: sum(m.witnessed for m in machines) >= parts * turn // (trouble + 1) or any(m.error for m in machines),
                       "parts go on", patience_s=600)
            if any(m.error for m in machines):
                break
            victim = dice.choice(machines)
            kind = dice.choices(list(kinds), [5, 5, 1])[0]
            kinds[kind] += 1
            if kind == "agent killed":
                victim.kill()
            elif kind == "link cut":
                victim.proxy.cut()
            else:
                shop.server.kill9()
                shop.start_server()
        for thread in threads:
            thread.join()
        for machine in machines:
            if machine.error:
                raise machine.error
        def settled():
            return all(m.agent.status()["state"] == "idle" and m.agent.status()["link"]["connected"]
                       and m.agent.status()["link"]["pending"] == 0 for m in machines)
        eventually(settled, "everything is at the server", patience_s=180)
        total = 0
        for machine in machines:
            count = machine.agent.status()["parts"]["count"]
            assert count == machine.share, f"{machine.agent.name}: {count} parts for {machine.share} starts that ended"
            rows = []
            cursor = None
            while True:
                page = shop.admin.get("/parts", machine=machine.agent.id, limit=1000, **({"cursor": cursor} if cursor else {}))
                rows += page["items"]
                cursor = page["next"]
                if not cursor:
                    break
            assert sorted(row["count"] for row in rows) == list(range(1, count + 1)), f"{machine.agent.name}: not each part once"
            total += count
        recounts = shop.admin.get("/counts/recount")["items"]
        assert all(one["identical"] for one in recounts), [one["differences"] for one in recounts if not one["identical"]]
        assert all(one["missing"] == 0 for one in recounts), recounts
        assert all(one["runs_open"] == 0 for one in recounts), recounts
        assert sum(one["parts"] for one in recounts) == total == parts, (total, parts)
        disagreements = shop.admin.get("/counts/disagreements")["items"]
        assert disagreements == [], disagreements
        figures = {"parts": total, "runs": sum(one["runs"] for one in recounts), "events": sum(one["events"] for one in recounts), **kinds}
        say(", ".join(f"{name}: {value}" for name, value in figures.items()))
        return figures
    finally:
        for machine in machines:
            machine.proxy.close()
        shop.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--agents", type=int, default=20)
    parser.add_argument("--parts", type=int, default=1000)
    parser.add_argument("--trouble", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    began = time.monotonic()
    run(options.agents, options.parts, options.trouble, options.seed)
    print(f"exact, in {time.monotonic() - began:.0f} s")


if __name__ == "__main__":
    sys.exit(main())
