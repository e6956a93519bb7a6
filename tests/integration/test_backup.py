"""Backups of a running server and of a machine, restored; damaged ones refused. The same server on PostgreSQL."""
import json
import os
import subprocess
import unittest

import parts
from shop import ADMIN_PASSWORD, ApiError, Client, Process, Shop, ShopTest, eventually, free_port, program


def restore(archive, data, *more):
    return subprocess.run([program("headstock-server"), "--data", data, "--restore", archive, *more],
                          capture_output=True, text=True, timeout=120)


class ServerBackup(ShopTest):
    def download(self, backup):
        path = os.path.join(self.shop.folder, backup["file"])
        with open(path, "wb") as file:
            file.write(self.shop.admin.get(f"/backups/{backup['id']}/file"))
        return path

    def test_a_running_server_is_restored_whole_into_an_empty_folder(self):
        self.shop.start_server()
        admin = self.shop.admin
        agent = self.shop.agent("Lathe 1", "fanuc-0i-t").start()
        self.make_resident(agent, "O1001", parts.LATHE)
        backup = admin.post("/backups")
        self.assertTrue(admin.get(f"/backups/{backup['id']}/verification")["whole"])
        archive = self.download(backup)
        after = admin.post("/folders", {"path": "/later"})
        self.assertTrue(after)
        self.shop.server.stop()

        data = os.path.join(self.shop.folder, "second")
        done = restore(archive, data)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("restored", done.stdout)
        self.assertNotEqual(restore(archive, data).returncode, 0, "never over something that is there")
        # The new server at the old address: people sign in as before, the machine trusts it and comes back by itself.
        os.rename(os.path.join(self.shop.folder, "server"), os.path.join(self.shop.folder, "lost"))
        os.rename(data, os.path.join(self.shop.folder, "server"))
        admin.token = None
        self.shop.start_server_only()
        admin.sign_in("admin", ADMIN_PASSWORD)
        self.assertEqual([p["name"] for p in admin.get("/programs")["items"]], ["O1001"])
        self.assertEqual(admin.call("GET", f"/programs/{admin.get('/programs')['items'][0]['id']}/revisions/1/content"), parts.LATHE.encode())
        self.assertNotIn("/later", [f["path"] for f in admin.get("/folders")["items"]])
        eventually(lambda: agent.live()["connected"], "the machine is back")
        self.assertTrue(admin.get("/audit/verification")["whole"], "the chain came over unbroken")

    def test_a_damaged_one_is_refused_and_nothing_is_made(self):
        self.shop.start_server()
        self.shop.upload("O1001", parts.LATHE)
        archive = self.download(self.shop.admin.post("/backups"))
        whole = open(archive, "rb").read()
        data = os.path.join(self.shop.folder, "second")
        for name, bytes_ in (("cut", whole[:len(whole) // 2]), ("flipped", whole[:200] + bytes([whole[200] ^ 1]) + whole[201:]),
                             ("text", b"not a backup at all"), ("empty", b"")):
            path = os.path.join(self.shop.folder, name)
            with open(path, "wb") as file:
                file.write(bytes_)
            done = restore(path, data)
            self.assertEqual(done.returncode, 1, (name, done.stdout, done.stderr))
            self.assertTrue("damaged" in done.stderr or "no backup" in done.stderr, (name, done.stderr))
            self.assertFalse(os.path.exists(os.path.join(data, "headstock.db")), name)
            with self.assertRaises(ApiError) as refused:
                self.shop.admin.call("POST", "/backups/file", raw=bytes_)
            self.assertIn(refused.exception.code, ("damaged_backup", "not_a_backup"), name)
        self.assertEqual(len(self.shop.admin.get("/backups")["items"]), 1)


class MachineBackup(ShopTest):
    def test_back_to_a_replacement_and_not_to_another_controller(self):
        self.shop.start_server()
        admin = self.shop.admin
        first = self.shop.agent("Lathe 1", "fanuc-0i-t").start()
        self.make_resident(first, "O1001", parts.LATHE)
        eventually(lambda: admin.get(f"/machines/{first.id}/programs")["items"], "census")
        backup = admin.post(f"/machines/{first.id}/backup")
        first.process.kill9()
        replacement = self.shop.agent("Lathe 1 new", "fanuc-0i-t").start()
        answer = admin.post(f"/machines/{replacement.id}/restore", {"backup": backup["id"]})
        self.assertEqual([p["name"] for p in answer["programs"]], ["O1001"], answer)
        eventually(lambda: [p["name"] for p in admin.get(f"/machines/{replacement.id}/programs")["items"]] == ["O1001"], "the program is there")
        other = admin.post("/machines", {"name": "Mill 1", "profile": "fanuc-0i-m"})["id"]
        with self.assertRaises(ApiError) as refused:
            admin.post(f"/machines/{other}/restore", {"backup": backup["id"]})
        self.assertEqual(refused.exception.code, "other_profile")


    # What stands on the machine's pages before the backup: every kind of value. A group of tool life is entered as on its page.
    VALUES = {"parameter/8132#0": 1, "parameter/6713": 50, "tool/1/geometry/X": -112.5, "tool/1/wear/X": 0.05, "tool/1/radius": 0.8,
              "tool/1/tip": 3, "tool/99/geometry/Z": -75.25, "work/G54/Z": -20, "work/shift/Z": 0.5, "variable/500": 2.5,
              "variable/501": -1, "tool_life/1/unit": 0, "tool_life/1/life": 3, "tool_life/1/tool/0": 1, "tool_life/1/offset/0": 1,
              "tool_life/1/tool/1": 2, "tool_life/1/offset/1": 2, "tool_life/1/used/0": 2, "tool_life/2/unit": 1,
              "tool_life/2/life": 600, "tool_life/2/tool/0": 5, "tool_life/2/offset/0": 5}
    # What the two groups have besides, entered by nobody: 0, and told by the machine's report a few seconds later.
    BESIDES = ["tool_life/1/used/1", "tool_life/2/used/0",
               *(f"tool_life/{group}/current" for group in (1, 2)),
               *(f"tool_life/{tool}" for field in ("h", "d", "skipped") for tool in (f"1/{field}/0", f"1/{field}/1", f"2/{field}/0"))]

    def write_by_hand(self, agent):
        agent.panel("mode", "mdi")
        agent.panel("parameter-write", "on")
        for what, value in self.VALUES.items():
            agent.panel("set", f"{what}={value}")
        self.lock(agent)

    def lock(self, agent):
        agent.panel("parameter-write", "off")
        agent.panel("reset")

    def values_at_server(self, agent):
        return self.shop.admin.get(f"/machines/{agent.id}/values")["values"]

    def seen(self, agent, wanted):
        eventually(lambda: all(abs(self.values_at_server(agent).get(what, 0) - value) < 1e-9 for what, value in wanted.items()),
                   "the server has what is on the machine")

    def on_its_disk(self, agent):
        """As the machine itself has them after a kill."""
        agent.process.kill9()
        agent.start()
        return {what: float(agent.panel("value", what)) for what in self.VALUES}

    def restore_to(self, agent, backup):
        return self.shop.admin.post(f"/machines/{agent.id}/restore", {"backup": backup["id"]})["values"]

    def test_every_value_comes_back_to_the_same_machine_and_to_a_replacement(self):
        self.shop.start_server()
        agent = self.shop.agent("Lathe 1", "fanuc-0i-t").start()
        self.write_by_hand(agent)
        self.seen(agent, self.VALUES)
        eventually(lambda: self.values_at_server(agent).keys() >= set(self.BESIDES), "the server has the groups whole")
        backup = self.shop.admin.post(f"/machines/{agent.id}/backup")
        self.assertEqual(self.restore_to(agent, backup)["state"], "same")

        # Somebody changes this and that; all of it comes back, or nothing while the parameter switch is off.
        agent.panel("parameter-write", "on")
        for change in ("tool/1/wear/X=0.07", "work/G54/Z=-21", "variable/500=", "variable/502=9", "parameter/6713=60", "tool/7/wear/Z=0.03",
                       "tool_life/1/used/0=0", "tool_life/3/unit=0", "tool_life/3/life=5", "tool_life/3/tool/0=7"):
            agent.panel("set", change)
        self.lock(agent)
        self.seen(agent, {"tool_life/1/used/0": 0, "parameter/6713": 60})
        refused = self.restore_to(agent, backup)
        self.assertEqual((refused["state"], refused["reason"], refused["where"]), ("refused", "parameter_write_off", "parameter/6713"))
        self.assertEqual(float(agent.panel("value", "tool/1/wear/X")), 0.07, "nothing of it was written")
        agent.panel("parameter-write", "on")
        done = self.restore_to(agent, backup)
        self.assertEqual((done["state"], done["differ"], done["without_place"]), ("done", 8, 0), done)
        self.lock(agent)
        self.assertEqual(self.on_its_disk(agent), self.VALUES)
        self.assertEqual([json.loads(agent.panel("value", what)) for what in ("tool/7/wear/Z", "variable/502", "tool_life/3/life")],
                         [0, 0, None], "what was not there is gone")
        history = self.shop.admin.get(f"/machines/{agent.id}/value-changes", what="work/G54/Z")["items"][0]
        self.assertEqual((history["origin"], history["before"], history["after"], history["by"]), ("restore", -21, -20, "admin"))

        agent.process.kill9()
        replacement = self.shop.agent("Lathe 1 new", "fanuc-0i-t").start()
        eventually(lambda: self.shop.admin.get(f"/machines/{replacement.id}/values")["reported"], "the new machine has told what it has")
        replacement.panel("mode", "mdi")
        replacement.panel("parameter-write", "on")
        done = self.restore_to(replacement, backup)
        self.assertEqual((done["state"], done["differ"], done["without_place"]), ("done", len(self.VALUES) + len(self.BESIDES), 0), done)
        self.lock(replacement)
        self.assertEqual(self.on_its_disk(replacement), self.VALUES)
        self.seen(replacement, self.VALUES)

@unittest.skipUnless(os.environ.get("HEADSTOCK_TEST_DATABASE"), "run by tests/with-postgresql")
class OnPostgresql(ShopTest):
    def setUp(self):
        super().setUp()
        self.shop.server_arguments = ["--database", self.database()]

    def database(self):
        server = os.environ["HEADSTOCK_TEST_DATABASE"]
        name = "it_" + os.urandom(6).hex()
        subprocess.run(["createdb", "--maintenance-db=" + server, name], check=True)
        return server + "&dbname=" + name

    def test_a_part_is_made_and_counted(self):
        self.shop.start_server()
        self.assertFalse(os.path.exists(os.path.join(self.shop.folder, "server", "headstock.db")))
        agent = self.shop.agent("Lathe 1", "fanuc-0i-t").start()
        self.make_resident(agent, "O1001", parts.LATHE)
        agent.arm()
        agent.command("cycle_start")
        eventually(lambda: agent.parts() == 1, "counted")
        eventually(lambda: self.shop.admin.get("/parts")["total"] == 1, "in the history")
        second = Process([program("headstock-server"), "--data", os.path.join(self.shop.folder, "other"), "--port", str(free_port()),
                          "--agent-port", str(free_port()), *self.shop.server_arguments], os.path.join(self.shop.folder, "other.log"))
        self.assertEqual(second.child.wait(30), 4, second.text())
        self.assertIn("in use", second.text())

    def test_a_backup_of_sqlite_is_restored_into_postgresql_and_back(self):
        arguments, self.shop.server_arguments = self.shop.server_arguments, []
        self.shop.start_server()
        made = self.shop.upload("轴 O1", parts.LATHE)
        archive = os.path.join(self.shop.folder, "a.tar.zst")
        for target in (arguments, []):
            backup = self.shop.admin.post("/backups")
            with open(archive, "wb") as file:
                file.write(self.shop.admin.get(f"/backups/{backup['id']}/file"))
            self.shop.server.stop()
            old = os.path.join(self.shop.folder, "server")
            os.rename(old, old + ".old" + str(len(target)))
            done = restore(archive, old, *target)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.shop.server_arguments = target
            self.shop.start_server_only()
            self.shop.admin.token = None
            self.shop.admin.sign_in("admin", ADMIN_PASSWORD)
            self.assertEqual(self.shop.admin.get(f"/programs/{made['program']['id']}")["name"], "轴 O1")
            self.shop.upload("later" + str(len(target)), parts.MILL)   # new ids follow the restored ones
            self.assertTrue(self.shop.admin.get("/audit/verification")["whole"])
