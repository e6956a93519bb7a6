"""Parts counted exactly: the small edition of count_parts.py on every commit, and the M code that a parameter makes count."""
import unittest

import count_parts
from shop import ShopTest, eventually


class Counts(unittest.TestCase):
    def test_parts_on_three_machines_with_fifteen_kills_and_cuts(self):
        figures = count_parts.run(agents=3, parts=36, trouble=15, seed=4, say=lambda text: None)
        self.assertEqual(figures["parts"], 36)
        self.assertGreaterEqual(figures["runs"], 36)


class CountedByAParameter(ShopTest):
    def test_two_parts_in_one_run_by_the_m_code_of_no_6710(self):
        """No.6710 = 85 counts at every M85, No.6700#0 = 1 keeps M02 and M30 from counting: two parts a run, both witnesses agree."""
        self.shop.start_server()
        agent = self.shop.agent("Lathe 1", "fanuc-0i-t").start()
        agent.panel("mode", "mdi")
        agent.panel("parameter-write", "on")
        agent.panel("set", "parameter/6710=85")
        agent.panel("set", "parameter/6700#0=1")
        agent.panel("parameter-write", "off")
        agent.panel("reset")
        agent.panel("mode", "memory")
        self.make_resident(agent, "O0085", "O85\nG21 G98\nG00 X40. Z2.\nM85\nG01 Z0. F6000.\nM85\nG00 X50. Z10.\nM30\n%\n")
        agent.panel("select", "O0085")
        for run in (1, 2):
            eventually(lambda: agent.panel("start") is not None, "started")
            eventually(lambda: agent.status()["parts"]["count"] == 2 * run and agent.status()["state"] == "idle", "two more parts")
        admin = self.shop.admin
        eventually(lambda: agent.status()["link"]["pending"] == 0 and len(admin.get(f"/machines/{agent.id}/runs")["items"]) == 2, "all is told")
        eventually(lambda: [run["parts"] for run in admin.get(f"/machines/{agent.id}/runs")["items"]] == [2, 2], "two parts in each run")
        self.assertEqual(admin.get("/parts", machine=agent.id)["total"], 4)
        recount = admin.get("/counts/recount")["items"][0]
        self.assertEqual((recount["parts"], recount["identical"]), (4, True), recount)
        self.assertEqual(admin.get("/counts/disagreements")["items"], [])


if __name__ == "__main__":
    unittest.main()
