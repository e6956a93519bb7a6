"""Backups of a running server and of a machine, restored; damaged ones refused. The same server on PostgreSQL."""
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
