"""The path of a part: upload, check, release, send, select, arm at the machine, cycle start, counted exactly once."""
import json
import subprocess

import parts
from shop import ApiError, ShopTest, eventually, program


class PathOfAPart(ShopTest):
    def setUp(self):
        super().setUp()
        self.shop.start_server()

    def run_one(self, agent):
        name, text = parts.BY_PROFILE[agent.profile]
        self.make_resident(agent, name, text)

        with self.assertRaises(ApiError) as refused:
            agent.command("cycle_start")
        self.assertEqual(refused.exception.status, 409)
        self.assertEqual(refused.exception.reason, "not_armed")
        self.assertEqual(agent.live()["state"], "idle", "a refused start must not move anything")

        agent.arm()
        self.assertTrue(agent.command("cycle_start")["accepted"])
        eventually(lambda: agent.parts() == 1, f"{agent.name} counted its part")
        eventually(lambda: agent.live()["state"] == "idle", f"{agent.name} idle again")

        counted = self.shop.admin.get("/parts", machine=agent.id)["items"]
        self.assertEqual(len(counted), 1, counted)
        def outcomes():
            return [run["outcome"] for run in self.shop.admin.get(f"/machines/{agent.id}/runs")["items"]]

        eventually(lambda: None not in outcomes(), "the run's record is closed")
        self.assertEqual(outcomes(), ["completed"])
        self.assertEqual(agent.status()["parts"]["count"], 1)

    def test_lathe_mill_and_gsk_lathe_each_make_one_part(self):
        agents = [self.shop.agent("Lathe 1", "fanuc-0i-t").start(), self.shop.agent("Mill 1", "fanuc-0i-m").start(),
                  self.shop.agent("Lathe 2", "gsk-2000tc").start()]
        for agent in agents:
            with self.subTest(agent.profile):
                self.run_one(agent)
        self.assertEqual([agent.parts() for agent in agents], [1, 1, 1])

    def test_the_command_line_does_the_same(self):
        agent = self.shop.agent("Lathe 1", "fanuc-0i-t").start()
        user, password = self.shop.administrator()
        home = {"HOME": self.shop.folder, "PATH": "/usr/bin:/bin", "LANG": "C.UTF-8"}

        def headstock(*words, status=0, stdin=None):
            done = subprocess.run([program("headstock"), *words], capture_output=True, text=True, env=home,
                                  input=stdin, timeout=120)
            self.assertEqual(done.returncode, status, f"{words}: {done.stdout}{done.stderr}")
            return done.stdout + done.stderr

        headstock("login", "--server", f"http://127.0.0.1:{self.shop.http_port}", "--user", user,
                  "--password-file", "-", stdin=password + "\n")
        path = self.shop.folder + "/O1001"
        with open(path, "w", encoding="ascii") as file:
            file.write(parts.LATHE)
        headstock("programs", "put", path, "--note", "first")
        listed = json.loads(headstock("programs", "list", "--json"))
        listed = listed["items"] if isinstance(listed, dict) else listed
        self.assertEqual([p["name"] for p in listed], ["O1001"])
        headstock("programs", "check", "O1001", "--machine", "Lathe 1")
        headstock("programs", "release", "O1001", "--why", "first article")
        headstock("programs", "send", "O1001", "Lathe 1")
        self.assertIn("arm", headstock("run", "Lathe 1", "O1001", "--wait", status=2).lower())
        agent.arm()
        headstock("run", "Lathe 1", "O1001", "--wait")
        eventually(lambda: agent.parts() == 1, "the part is on the card")
        self.assertIn("O1001", headstock("parts", "--machine", "Lathe 1"))
        self.assertIn("Lathe 1", headstock("machines"))


if __name__ == "__main__":
    import unittest
    unittest.main()
