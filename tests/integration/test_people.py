"""Rights a machine and an action, screens that only look, sign-ins that end, the audit trail: asked of a real server."""
import csv
import io
import os
import sqlite3
import subprocess
import urllib.error
import urllib.request

from shop import ADMIN_PASSWORD, ApiError, Client, ShopTest, eventually, program


class People(ShopTest):
    def setUp(self):
        super().setUp()
        self.shop.start_server()
        self.admin = self.shop.admin
        self.lathes = [self.admin.post("/machines", {"name": f"Lathe {i}", "profile": "fanuc-0i-t"})["id"] for i in (1, 2)]

    def refused(self, code, call, *args, **more):
        with self.assertRaises(ApiError) as refused:
            call(*args, **more)
        self.assertEqual(refused.exception.code, code, refused.exception)
        return refused.exception

    def test_a_right_on_one_machine_is_no_right_elsewhere(self):
        person = self.shop.person("li", "operator")
        user = next(u for u in self.admin.get("/users")["items"] if u["user"] == "li")["id"]
        one, two = self.lathes
        change = lambda machine: person.call("PATCH", f"/machines/{machine}", {"parts_required": 5})
        self.refused("forbidden", change, one)
        group = self.admin.post("/machine-groups", {"name": "Cell A", "machines": [one]})["id"]
        self.admin.call("PATCH", f"/users/{user}/grants", {"grants": [{"group": group, "role": "setter"}]})
        self.assertEqual(change(one)["parts_required"], 5)
        self.assertEqual(person.get("/session")["machine_roles"], {str(one): "setter"})
        self.refused("forbidden", change, two)
        self.refused("forbidden", person.get, "/users")
        # The group changes, the rights with it, at once.
        self.admin.call("PATCH", f"/machine-groups/{group}", {"name": "Cell A", "machines": [two]})
        self.refused("forbidden", change, one)
        change(two)
        # One action forbidden in spite of the role: everything else stays.
        self.admin.call("PATCH", f"/users/{user}/grants", {"grants": [{"group": group, "role": "setter"},
                                                                      {"machine": two, "action": "edit_machine", "allow": False}]})
        self.refused("forbidden", change, two)
        # A command reaches the machine's own answer where it is allowed, and not where it is forbidden.
        self.admin.call("PATCH", f"/users/{user}/grants", {"grants": [{"machine": one, "action": "command_machine", "allow": False}]})
        self.refused("forbidden", person.post, f"/machines/{one}/commands", {"action": "feed_hold"})
        self.refused("machine_refused", person.post, f"/machines/{two}/commands", {"action": "feed_hold"})
        self.refused("forbidden", person.post, "/distributions", {"program": 1, "revision": 1, "machines": [one, two]})

    def test_the_first_password_lets_nobody_do_more_than_change_it(self):
        self.admin.post("/users", {"user": "new", "name": "", "role": "administrator", "password": "given by admin"})
        new = Client(self.admin.base).sign_in("new", "given by admin")
        self.assertTrue(new.get("/session")["must_change_password"])
        for method, path, body in (("GET", "/machines", None), ("GET", "/users", None), ("POST", "/machines", {}), ("GET", "/events", None)):
            self.refused("must_change_password", new.call, method, path, body)
        self.refused("weak_password", new.post, "/session/password", {"old": "given by admin", "new": "given by admin"})
        self.refused("common_password", new.post, "/session/password", {"old": "given by admin", "new": "password1"})
        new.post("/session/password", {"old": "given by admin", "new": "a fine one 5"})
        self.assertEqual(len(new.get("/machines")["items"]), 2)

    def test_a_screen_looks_and_nothing_else(self):
        made = self.admin.post("/view-tokens", {"name": "Hall 1"})
        screen = Client(self.admin.base)
        screen.token = made["token"]
        self.assertEqual(len(screen.get("/machines")["items"]), 2)
        self.assertTrue(screen.get("/session")["look_only"])
        for method, path, body in (("PATCH", "/session", {"name": "x"}), ("POST", "/session/password", {"old": "a", "new": "b"})):
            self.refused("look_only", screen.call, method, path, body)
        self.refused("forbidden", screen.get, "/users")
        self.assertNotIn("token", self.admin.get("/view-tokens")["items"][0])
        self.admin.call("DELETE", f"/view-tokens/{made['id']}")
        self.refused("unauthenticated", screen.get, "/machines")

    def test_guessing_over_many_users_locks_the_address(self):
        for i in range(20):
            self.refused("wrong_sign_in", Client(self.admin.base).sign_in, f"user{i}", "summer 2026")
        locked = self.refused("locked_out", Client(self.admin.base).sign_in, "admin", ADMIN_PASSWORD)
        self.assertEqual(locked.status, 429)
        self.assertEqual(len(self.admin.get("/machines")["items"]), 2, "who is signed in goes on")

    def test_every_list_is_a_table_for_a_spreadsheet(self):
        url = self.admin.base + "/api/v1/audit?format=csv&limit=1"
        request = urllib.request.Request(url, headers={"Authorization": "Bearer " + self.admin.token})
        with urllib.request.urlopen(request) as answer:
            self.assertIn("text/csv", answer.headers["Content-Type"])
            self.assertIn("audit.csv", answer.headers["Content-Disposition"])
            text = answer.read().decode("utf-8-sig")
        rows = list(csv.DictReader(io.StringIO(text)))
        self.assertEqual(len(rows), self.admin.get("/audit/verification")["rows"], "all rows, not a page")
        for path in ("/machines", "/users", "/alarms", "/parts", "/oee", "/transfers", "/permissions", "/alarm-events", "/backups"):
            self.assertTrue(self.admin.call("GET", path, query={"format": "csv"}).startswith(b"\xef\xbb\xbf"), path)
        self.refused("bad_request", self.admin.call, "GET", "/health", query={"format": "csv"})

    def headstock(self, *words, status=0, stdin=None):
        done = subprocess.run([program("headstock"), *words], capture_output=True, text=True, input=stdin, timeout=120,
                              env={"HOME": self.shop.folder, "PATH": "/usr/bin:/bin", "LANG": "C.UTF-8"})
        self.assertEqual(done.returncode, status, done.stdout + done.stderr)
        return done.stdout

    def test_the_audit_trail_shows_what_was_tampered_with(self):
        self.headstock("login", "--server", self.admin.base, "--user", "admin", "--password-file", "-", stdin=ADMIN_PASSWORD + "\n")
        seen = os.path.join(self.shop.folder, "seen")
        self.assertIn("whole", self.headstock("audit", "verify", "--seen", seen))
        self.headstock("audit", "verify", "--seen", seen)
        database = os.path.join(self.shop.folder, "server", "headstock.db")

        def tamper(*statements):
            """With the server stopped, as somebody who has the file."""
            self.assertEqual(self.shop.server.stop(), 0)
            with sqlite3.connect(database) as db:
                db.execute("DROP TRIGGER IF EXISTS audit_kept_update")
                db.execute("DROP TRIGGER IF EXISTS audit_kept_delete")
                for statement in statements:
                    db.execute(statement)
            db.close()
            self.shop.start_server()

        kept = open(database, "rb").read()
        last = self.admin.get("/audit/verification")["rows"]
        tamper(f"DELETE FROM audit WHERE id > {last - 3}")
        self.assertIn("whole", self.headstock("audit", "verify"), "alone it cannot know")
        self.assertIn("cut", self.headstock("audit", "verify", "--seen", seen, status=2))
        tamper("UPDATE audit SET user = 'nobody' WHERE id = 2")
        self.assertIn("row 2", self.headstock("audit", "verify", status=2))
        tamper("DELETE FROM audit WHERE id = 2")
        self.assertIn("row 2 missing", self.headstock("audit", "verify", status=2))
        self.assertTrue(kept)
