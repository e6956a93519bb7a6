"""Drip-feed: 30 MB (HEADSTOCK_DRIP_MB=100: the whole measure) through a machine that holds 2 MB, the link cut twenty times,
memory bounded, nothing lost."""
import os

from shop import CuttingProxy, PATIENCE_S, ShopTest, eventually

MIB = 1 << 20
SIZE = int(os.environ.get("HEADSTOCK_DRIP_MB", "30")) * 10**6
CUTS = 20


def write_program(path, size):
    """Short zig-zag cuts, like a CAM system's, of at least `size` bytes; returns where the last one ends."""
    with open(path, "w", encoding="ascii", newline="\n") as file:
        written = file.write("%\nO3001\nG21 G90 G94 G54\nG00 X0. Y0. Z10.\n")
        step = 0
        while written < size:
            block = []
            for _ in range(5000):
                x, y = (step % 200) * 0.5, (step // 200 % 200) * 0.5
                block.append(f"N{step % 100000:05d} G01 X{x if (step // 200) % 2 == 0 else 99.5 - x:.3f} Y{y:.3f} F8000.\n")
                step += 1
            written += file.write("".join(block))
        file.write("G00 Z20.\nM30\n%\n")
    step -= 1
    column, row = step % 200, step // 200
    return {"X": column * 0.5 if row % 2 == 0 else 99.5 - column * 0.5, "Y": row % 200 * 0.5}


class DripFeed(ShopTest):
    def test_a_program_far_beyond_the_memory_with_twenty_cuts(self):
        self.shop.start_server()
        path = os.path.join(self.shop.folder, "big.nc")
        last = write_program(path, SIZE)
        total = os.path.getsize(path)
        # The machine's clock runs as fast as it can: the path, the buffers and the link are the same as in real time.
        agent = self.shop.agent("Mill 1", "fanuc-0i-m", extra=["--clock", "fast"])
        proxy = CuttingProxy(self.shop.agent_port)
        self.addCleanup(proxy.close)
        agent.start(port=proxy.port)

        processes = (agent.process, self.shop.server)
        before = [process.peak_memory_mib() for process in processes]
        with open(path, "rb") as file:
            made = self.shop.admin.call("POST", "/programs", raw=file.read(),
                                        query={"folder": "", "name": "O3001", "note": "drip"}, timeout=300)
        program_id, revision = made["program"]["id"], made["revision"]["number"]
        self.assertEqual(made["revision"]["bytes"], total)
        check = self.shop.check(program_id, revision, agent)
        self.assertTrue(check["ok"], check)
        self.shop.admin.post(f"/programs/{program_id}/revisions/{revision}/release", {"why": "drip-feed test"})
        agent.arm()
        transfer = self.shop.admin.post(f"/machines/{agent.id}/drip", {"program_id": program_id, "revision": revision})

        def progress():
            return next(t for t in self.shop.admin.get("/transfers")["items"] if t["id"] == transfer["id"])

        eventually(lambda: proxy.bytes_down > MIB, "the buffer of the machine fills")
        agent.panel("start")
        for cut in range(1, CUTS + 1):
            goal = total * cut // (CUTS + 2)
            eventually(lambda: proxy.bytes_down > goal, f"{goal} bytes sent", 20 * PATIENCE_S)
            self.assertTrue(proxy.cut(), f"cut {cut}")
            # A machine that ran dry meanwhile is in feed hold and goes on only when a person says so.
            eventually(lambda: agent.live()["connected"], "reconnected")
            status = agent.status()
            if status["state"] in ("hold", "alarm"):
                if status["state"] == "alarm":
                    agent.panel("reset")
                agent.panel("start")

        def finished():
            status = agent.status()
            if status["state"] == "hold":
                agent.panel("start")
            return status["parts"]["count"] == 1

        eventually(finished, "the whole program was executed", 20 * PATIENCE_S)
        eventually(lambda: progress()["state"] == "done", "transfer done")
        self.assertEqual(proxy.cuts, CUTS)
        self.assertEqual(progress()["bytes"], total)
        # The record of the run comes over the link behind the count.
        eventually(lambda: self.shop.admin.get(f"/machines/{agent.id}/runs")["items"][0]["outcome"], "the run's record is closed")
        self.assertEqual(self.shop.admin.get(f"/machines/{agent.id}/runs")["items"][0]["outcome"], "completed")
        last["Z"] = 20.0

        def where_it_should_be():
            status = agent.status()   # measured by the drives, which settle
            return all(abs(last[axis] - place) < 1e-4 for axis, place in zip(status["axes"], status["absolute"]))

        eventually(where_it_should_be, "the axes stand where the last blocks say")
        for process, peak in zip(processes, before):
            self.assertLess(process.peak_memory_mib(), peak + 15, "a program of any length passes through the same memory")
