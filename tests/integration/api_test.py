"""The interface of a real server over real sockets: every route, every role, and clients that misbehave."""

import concurrent.futures
import hashlib
import json
import os
import pathlib
import signal
import socket
import stat
import struct
import subprocess
import tempfile
import time
import unittest

from api_schema import mistakes
from api_server import CLIENT, SERVER, Client, Server

ROLES = ["viewer", "operator", "programmer", "setter", "administrator"]
PROGRAM = "%\nO1001\nG21 G40 G97 G99\nG28 U0 W0\nT0101\nS1000 M03\nG00 X50. Z2.\nG01 Z-20. F0.2\nG00 X60.\nM30\n%\n"


def until(condition, what, seconds=20):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError("never happened: " + what)


class WithServer(unittest.TestCase):
    arguments = ()

    @classmethod
    def setUpClass(cls):
        cls.server = Server(arguments=cls.arguments).start()
        cls.addClassCleanup(cls.server.close)
        cls.admin = cls.server.administrator()
        cls.people = {}
        for role in ROLES:
            cls.admin.ok("POST", "/users", {"user": "t_" + role, "password": "a good Passw0rd", "role": role,
                                           "must_change_password": False})
            cls.people[role] = Client(cls.server).sign_in("t_" + role, "a good Passw0rd")

    def alive(self):
        self.assertEqual(Client(self.server).ok("GET", "/health")["status"], "ok")


class EveryRoute(WithServer):
    """Nothing in the description that the handlers do not do."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.document = Client(cls.server).ok("GET", "/openapi.json")

    def filled(self, path):
        return path.replace("{id}", "999999").replace("{n}", "1").replace("{name}", "O1")

    def routes(self):
        for path, operations in self.document["paths"].items():
            for method, operation in operations.items():
                yield path, method.upper(), operation

    def test_every_role_at_every_route(self):
        checked = 0
        for path, method, operation in self.routes():
            if operation["x-role"] == "" or path in ("/session", "/session/password"):
                continue
            needed = ROLES.index(operation["x-role"])
            body = None if method == "GET" else {}
            status, answer, _ = Client(self.server).call(method, self.filled(path), body)
            self.assertEqual((status, answer["error"]["code"]), (401, "unauthenticated"), (method, path))
            for rank, role in enumerate(ROLES):
                if rank >= needed:
                    # Reached, whatever it says of an id that is not there. 403 would be the gate.
                    status, answer, _ = self.people[role].call(method, self.filled(path), body)
                    self.assertNotIn(status, (401, 403, 500), (method, path, role, answer))
                else:
                    status, answer, _ = self.people[role].call(method, self.filled(path), body)
                    self.assertEqual((status, answer["error"]["code"]), (403, "forbidden"), (method, path, role))
                checked += 1
        self.assertGreater(checked, 150)

    def test_answers_fit_the_description(self):
        admin = self.admin
        machine = admin.ok("POST", "/machines", {"name": "Schema lathe", "profile": "fanuc-0i-t"})
        up = admin.upload("O1001.nc", PROGRAM, "/schema", "first")
        again = admin.upload("O1001.nc", PROGRAM.replace("F0.2", "F0.3"), "/schema", "feed")
        program, number = up["program"]["id"], again["revision"]["number"]
        job_free = {"machine": machine["id"]}
        check = admin.call("POST", f"/programs/{program}/revisions/{number}/check", job_free)
        self.assertIn(check[0], (200, 202), check)
        calls = {
            ("GET", "/health"): None, ("GET", "/profiles"): None, ("GET", "/session"): None, ("GET", "/users"): None,
            ("GET", "/machines"): None, ("GET", "/machines/{id}"): None, ("PATCH", "/machines/{id}"): {"parts_required": 5},
            ("POST", "/machines/{id}/enrolment"): {}, ("GET", "/machines/{id}/programs"): None,
            ("GET", "/machines/{id}/offsets"): None, ("GET", "/machines/{id}/runs"): None, ("GET", "/machines/{id}/parts"): None,
            ("GET", "/machines/{id}/states"): None, ("GET", "/alarms"): None, ("GET", "/parts"): None, ("GET", "/audit"): None,
            ("GET", "/folders"): None, ("POST", "/folders"): {"path": "/made/here"}, ("GET", "/programs"): None,
            ("GET", "/programs/{id}"): None, ("PATCH", "/programs/{id}"): {"name": "O1002.nc"},
            ("GET", "/programs/{id}/revisions"): None, ("GET", "/programs/{id}/revisions/{n}/checks"): None,
            ("GET", "/transfers"): None, ("PATCH", "/session"): {"language": "zh"},
            ("PATCH", "/calendar"): {"time_zone": "Asia/Shanghai", "shifts": [{"name": "白班", "days": [1, 2, 3, 4, 5], "start": "08:00", "end": "20:00"}]},
            ("GET", "/calendar"): None, ("GET", "/downtime-reasons"): None,
            ("POST", "/downtime-reasons"): {"name_en": "Coolant", "name_zh": "换冷却液", "planned": True},
            ("POST", "/machines/{id}/downtime"): {"from": "2026-01-05T08:00:00Z", "to": "2026-01-05T09:00:00Z", "reason": 1, "note": "jaws"},
            ("GET", "/machines/{id}/downtime"): None, ("GET", "/machines/{id}/stops"): None,
            ("POST", "/machines/{id}/rejects"): {"quantity": 2, "why": "chatter"}, ("GET", "/machines/{id}/rejects"): None,
            ("GET", "/oee"): None, ("GET", "/alarms/statistics"): None,
        }
        for (method, path), body in calls.items():
            with self.subTest(method=method, path=path):
                operation = self.document["paths"][path][method.lower()]
                target = path.replace("{n}", str(number)).replace("{id}", str(machine["id"] if "/machines" in path else program))
                status, answer, _ = admin.call(method, target, body)
                self.assertIn(str(status), operation["responses"], answer)
                self.assertLess(status, 300, answer)
                schema = operation["responses"][str(status)]["content"]["application/json"]["schema"]
                self.assertEqual(mistakes(answer, schema, self.document), [])
        diff = admin.ok("GET", f"/programs/{program}/diff?from=1&to={number}")
        self.assertEqual(mistakes(diff, {"$ref": "#/components/schemas/Difference"}, self.document), [])
        self.assertEqual(diff["classes"], ["feed_speed"])
        self.assertEqual(mistakes(machine, {"$ref": "#/components/schemas/NewMachineAnswer"}, self.document), [])
        self.assertEqual(mistakes(up, {"$ref": "#/components/schemas/Uploaded"}, self.document), [])
        sent = admin.ok("POST", "/distributions", {"program": program, "revision": number, "machines": [machine["id"]]})
        self.assertEqual(mistakes(sent, {"$ref": "#/components/schemas/Distribution"}, self.document), [])

    def test_wrong_times_and_shifts_are_refused_in_words(self):
        machine = self.admin.ok("POST", "/machines", {"name": "Clock lathe", "profile": "fanuc-0i-t"})["id"]
        shift = {"name": "A", "days": [1], "start": "06:00", "end": "14:00"}
        for method, path, body, code in [
                ("PATCH", "/calendar", {"time_zone": "Moon/Base", "shifts": []}, "bad_value"),
                ("PATCH", "/calendar", {"time_zone": "Etc/UTC", "shifts": [shift, {**shift, "start": "13:00", "end": "20:00"}]}, "shifts_overlap"),
                ("PATCH", "/calendar", {"time_zone": "Etc/UTC", "shifts": [{**shift, "start": "25:00"}]}, "bad_request"),
                ("PATCH", "/calendar", {"time_zone": "Etc/UTC", "shifts": [{**shift, "days": [8]}]}, "bad_request"),
                ("POST", f"/machines/{machine}/downtime", {"from": "2090-01-01", "to": "2090-01-02", "reason": 1}, "in_the_future"),
                ("POST", f"/machines/{machine}/downtime", {"from": "2026-01-02", "to": "2026-01-01", "reason": 1}, "bad_value"),
                ("POST", f"/machines/{machine}/rejects", {"quantity": 0, "why": "x"}, "bad_value"),
                ("GET", "/oee?by=moon", None, "bad_request"), ("GET", "/oee?from=2020-01-01&to=2026-01-01", None, "bad_value")]:
            status, answer, _ = self.admin.call(method, path, body)
            self.assertEqual((answer.get("error") or {}).get("code"), code, (method, path, body, answer))
            self.assertGreaterEqual(status, 400)

    def test_refusals_have_the_shape_of_an_error(self):
        for method, path, body in [("GET", "/nothing", None), ("GET", "/programs/999999", None), ("GET", "/alarms?from=x", None),
                                   ("POST", "/users", {}), ("PUT", "/users", None), ("GET", "/audit?limit=0", None)]:
            status, answer, _ = self.admin.call(method, path, body)
            self.assertGreaterEqual(status, 400)
            self.assertEqual(mistakes(answer, {"$ref": "#/components/schemas/Error"}, self.document), [], (path, answer))
            self.assertNotEqual(answer["error"]["message"]["en"], answer["error"]["message"]["zh"])


class Sessions(WithServer):
    def test_cookie_needs_the_header_to_change_anything(self):
        status, answer, headers = Client(self.server).call("POST", "/session", {"user": "t_setter", "password": "a good Passw0rd"})
        self.assertEqual(status, 200)
        cookie = headers["Set-Cookie"]
        for part in ("headstock_session=", "HttpOnly", "SameSite=Strict", "Path=/"):
            self.assertIn(part, cookie)
        browser = Client(self.server, cookie=answer["token"])
        self.assertEqual(browser.call("GET", "/session")[0], 200)
        status, refused, _ = browser.call("POST", "/folders", {"path": "/x"})
        self.assertEqual((status, refused["error"]["code"]), (403, "cross_site"))
        self.assertEqual(browser.call("POST", "/folders", {"path": "/x"}, {"X-Headstock": "1"})[0], 201)

    def test_sign_out_ends_the_token(self):
        person = Client(self.server).sign_in("t_viewer", "a good Passw0rd")
        self.assertEqual(person.call("DELETE", "/session")[0], 204)
        self.assertEqual(person.call("GET", "/session")[0], 401)

    def test_repeated_wrong_passwords_lock(self):
        self.admin.ok("POST", "/users", {"user": "forgetful", "password": "a good Passw0rd", "role": "viewer", "must_change_password": False})
        seen = [Client(self.server).call("POST", "/session", {"user": "forgetful", "password": "wrong"})[0] for _ in range(8)]
        self.assertEqual(seen[0], 401)
        self.assertEqual(seen[-1], 429)
        self.assertEqual(Client(self.server).call("POST", "/session", {"user": "forgetful", "password": "a good Passw0rd"})[0], 429)

    def test_json_must_say_it_is_json(self):
        status, answer, _ = Client(self.server).call("POST", "/session", raw=b'{"user":"a","password":"b"}', headers={"Content-Type": "text/plain"})
        self.assertEqual((status, answer["error"]["code"]), (415, "bad_content_type"))

    def test_every_reply_carries_the_security_headers(self):
        for path, prefix in (("/health", "/api/v1"), ("/", ""), ("/nothing", "/api/v1")):
            _, _, headers = Client(self.server).call("GET", path, prefix=prefix)
            self.assertEqual(headers["X-Content-Type-Options"], "nosniff")
            self.assertIn("script-src 'self'", headers["Content-Security-Policy"])
            self.assertIn("frame-ancestors 'none'", headers["Content-Security-Policy"])


class Uploads(WithServer):
    def stored(self):
        return sorted(str(p) for p in (self.server.data / "blobs").rglob("*") if p.is_file())

    def test_bytes_come_back_exactly(self):
        text = bytes(range(1, 256)) * 4000
        up = self.people["programmer"].upload("odd.bin", text)
        self.assertEqual(up["revision"]["sha256"], hashlib.sha256(text).hexdigest())
        path = f"/programs/{up['program']['id']}/revisions/1/content"
        self.assertEqual(self.people["viewer"].ok("GET", path), text)
        status, part, headers = self.people["viewer"].call("GET", path, headers={"Range": "bytes=10-19"})
        self.assertEqual((status, part), (206, text[10:20]))
        self.assertEqual(headers["Content-Range"], f"bytes 10-19/{len(text)}")
        self.assertEqual(self.people["viewer"].call("GET", path, headers={"Range": "bytes=-5"})[1], text[-5:])
        self.assertEqual(self.people["viewer"].call("GET", path, headers={"Range": f"bytes={len(text)}-"})[0], 416)

    def test_an_upload_cut_half_way_leaves_nothing(self):
        before = self.stored()
        programs = len(self.admin.ok("GET", "/programs")["items"])
        token = self.people["programmer"].token
        for announced in (True, False):
            with self.server.raw() as s:
                length = "Content-Length: 1000000" if announced else "Transfer-Encoding: chunked"
                s.sendall(f"POST /api/v1/programs?name=cut.nc HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {token}\r\n{length}\r\n\r\n".encode())
                s.sendall(b"G01 X1\n" * 10000 if announced else b"7\r\nG01 X1\n\r\n" * 1000)
                s.shutdown(socket.SHUT_WR)
                answer = s.recv(65536)
            self.assertIn(b"upload_incomplete", answer)
        until(lambda: self.stored() == before, "the half upload's file is gone")
        self.assertEqual(len(self.admin.ok("GET", "/programs")["items"]), programs)

    def test_a_hundred_megabytes_never_in_memory(self):
        def resident():
            for line in pathlib.Path(f"/proc/{self.server.process.pid}/status").read_text().splitlines():
                if line.startswith("VmHWM"):
                    return int(line.split()[1]) * 1024
        before = resident()
        block = b"".join(b"G01 X%d. Y%d. F500\n" % (i % 1000, i % 777) for i in range(50_000))
        pieces = 105_000_000 // len(block)
        digest = hashlib.sha256()
        with self.server.raw(60) as s:
            s.sendall((f"POST /api/v1/programs?name=huge.nc HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {self.people['programmer'].token}\r\n"
                       f"Content-Length: {pieces * len(block)}\r\nConnection: close\r\n\r\n").encode())
            for _ in range(pieces):
                s.sendall(block)
                digest.update(block)
            answer = b""
            while piece := s.recv(65536):
                answer += piece
        self.assertIn(b"200 OK", answer.split(b"\r\n", 1)[0])
        up = json.loads(answer.split(b"\r\n\r\n", 1)[1])
        self.assertEqual(up["revision"]["sha256"], digest.hexdigest())
        path = f"/programs/{up['program']['id']}/revisions/1/content"
        window = self.people["viewer"].ok("GET", path + "?from_line=1000001&lines=3")
        self.assertEqual(window["lines"][0], "G01 X0. Y0. F500")
        self.assertEqual(window["total"], up["revision"]["lines"])
        got = hashlib.sha256(self.people["viewer"].ok("GET", path)).hexdigest()
        self.assertEqual(got, digest.hexdigest())
        self.assertLess(resident() - before, 40_000_000)

    def test_bad_names_are_refused_before_the_bytes(self):
        for name in ("", "..", "a/b", "a\\b", "x" * 200, "a\nb"):
            status, answer, _ = self.people["programmer"].call("POST", "/programs?name=" + __import__("urllib.parse").parse.quote(name, safe=""), raw=b"x")
            self.assertEqual((status, answer["error"]["code"]), (400, "bad_name"), name)

    def test_traversal_reaches_no_file(self):
        for path in ("/../../../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/..%2f..%2fetc%2fpasswd", "/assets/../../lock"):
            _, content, _ = Client(self.server).call("GET", path, prefix="")
            self.assertNotIn(b"root:", content if isinstance(content, bytes) else b"")


class FullDisk(unittest.TestCase):
    @unittest.skipUnless(os.geteuid() == 0, "needs root for a small file system")
    def test_a_full_disk_refuses_and_goes_on(self):
        folder = tempfile.mkdtemp(prefix="headstock-full-")
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=12m", "tmpfs", folder], capture_output=True).returncode:
            self.skipTest("may not mount")
        self.addCleanup(os.rmdir, folder)
        self.addCleanup(subprocess.run, ["umount", folder])
        server = Server(data=pathlib.Path(folder) / "data")
        (pathlib.Path(folder) / "data").mkdir()
        server.start()
        self.addCleanup(server.stop)
        admin = server.administrator()
        admin.upload("small.nc", PROGRAM)
        status, answer, _ = admin.call("POST", "/programs?name=big.nc", raw=b"G01 X1 Y1\n" * 3_000_000)
        self.assertEqual((status, answer["error"]["code"]), (507, "disk_full"))
        names = [p["name"] for p in admin.ok("GET", "/programs")["items"]]
        self.assertEqual(names, ["small.nc"])
        admin.upload("after.nc", PROGRAM + "(after)\n")   # room again: the half file has gone
        self.assertEqual(Client(server).ok("GET", "/health")["status"], "ok")


class Misbehaviour(WithServer):
    def talk(self, data, timeout=20):
        with self.server.raw(timeout) as s:
            try:
                s.sendall(data)
                s.shutdown(socket.SHUT_WR)
            except OSError:
                pass
            answer = b""
            try:
                while piece := s.recv(65536):
                    answer += piece
            except OSError:
                pass
            return answer

    def test_garbage(self):
        for data in (b"\x00\x01\x02\x03" * 100, b"GET\r\n\r\n", b"HELO x\r\n\r\n", os.urandom(5000), b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
                     b"GET / HTTP/1.1\r\nContent-Length: -1\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n",
                     b"POST /api/v1/session HTTP/1.1\r\nHost: x\r\nContent-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"):
            answer = self.talk(data)
            self.assertNotIn(b" 200 ", answer.split(b"\r\n", 1)[0], data[:40])
        self.alive()

    def test_headers_have_a_limit(self):
        answer = self.talk(b"GET / HTTP/1.1\r\nHost: x\r\nX-Long: " + b"a" * 200_000 + b"\r\n\r\n")
        self.assertIn(b" 431 ", answer.split(b"\r\n", 1)[0])
        self.alive()

    def test_json_bodies_have_a_limit(self):
        status, answer, _ = self.admin.call("POST", "/folders", raw=b" " * 2_000_000, headers={"Content-Type": "application/json"})
        self.assertEqual((status, answer["error"]["code"]), (413, "too_large"))
        deep = b'{"path":' + b"[" * 100_000 + b"]" * 100_000 + b"}"
        self.assertEqual(self.admin.call("POST", "/folders", raw=deep, headers={"Content-Type": "application/json"})[0], 400)
        self.assertEqual(self.admin.call("POST", "/folders", raw=b"{", headers={"Content-Type": "application/json"})[0], 400)
        self.alive()

    def test_requests_follow_each_other_on_one_connection(self):
        with self.server.raw() as s:
            for _ in range(3):
                s.sendall(b"GET /api/v1/health HTTP/1.1\r\nHost: x\r\n\r\n")
                self.assertIn(b"200 OK", s.recv(65536))

    def test_many_clients_at_once(self):
        with concurrent.futures.ThreadPoolExecutor(32) as pool:
            answers = list(pool.map(lambda _: self.people["viewer"].call("GET", "/machines")[0], range(300)))
        self.assertEqual(set(answers), {200})

    def test_more_connections_than_allowed_are_told_so(self):
        held = [self.server.raw() for _ in range(512)]
        try:
            answer = until(lambda: self.talk(b"GET /api/v1/health HTTP/1.1\r\nHost: x\r\n\r\n", 5), "an answer")
            self.assertIn(b" 503 ", answer.split(b"\r\n", 1)[0])
        finally:
            for s in held:
                s.close()
        until(lambda: Client(self.server).call("GET", "/health")[0] == 200, "room again")


class WebSocket:
    """Just enough of RFC 6455 for a client that may also stop reading."""

    def __init__(self, server, token, origin=None, buffer=None):
        self.s = socket.socket()
        if buffer:
            self.s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        self.s.settimeout(20)
        self.s.connect(("127.0.0.1", server.port))
        head = (f"GET /api/v1/events HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n")
        head += f"Authorization: Bearer {token}\r\n" if token else ""
        head += f"Origin: {origin}\r\n" if origin else ""
        self.s.sendall((head + "\r\n").encode())
        self.head = b""
        while b"\r\n\r\n" not in self.head:
            self.head += self.s.recv(1)

    def send(self, text):
        data = text if isinstance(text, bytes) else text.encode()
        length = bytes([0x80 | len(data)]) if len(data) < 126 else struct.pack(">BQ", 0xFF, len(data))
        self.s.sendall(b"\x81" + length + b"\0\0\0\0" + data)

    def exactly(self, count):
        data = b""
        while len(data) < count:
            piece = self.s.recv(count - len(data))
            if not piece:
                raise ConnectionError
            data += piece
        return data

    def receive(self):
        first, second = self.exactly(2)
        length = second & 127
        if length == 126:
            length, = struct.unpack(">H", self.exactly(2))
        elif length == 127:
            length, = struct.unpack(">Q", self.exactly(8))
        data = self.exactly(length)
        return self.receive() if first & 15 in (9, 10) else json.loads(data)

    def close(self):
        self.s.close()


class Events(WithServer):
    def test_without_a_session_no_socket(self):
        for token, origin, status in ((None, None, b" 401 "), (self.admin.token, "http://evil.example", b" 403 ")):
            ws = WebSocket(self.server, token, origin)
            self.addCleanup(ws.close)
            self.assertIn(status, ws.head)
        self.assertEqual(self.admin.call("GET", "/events")[0], 426)

    def test_snapshot_then_events(self):
        ws = WebSocket(self.server, self.people["viewer"].token)
        self.addCleanup(ws.close)
        self.assertIn(b" 101 ", ws.head)
        ws.send('{"subscribe":["floor","programs"]}')
        first = ws.receive()
        self.assertEqual(first["type"], "snapshot")
        made = self.admin.ok("POST", "/machines", {"name": "Seen", "profile": "fanuc-0i-m"})
        seen = []
        while not any(m["type"] == "machine" for m in seen):
            seen.append(ws.receive())
        self.admin.upload("seen.nc", PROGRAM)
        while not any(m["type"] == "program" for m in seen):
            seen.append(ws.receive())
        while not any(m["type"] == "tick" for m in seen):
            seen.append(ws.receive())
        ws.send('{"subscribe":["machine:%d"]}' % made["id"])
        while (message := ws.receive())["type"] != "snapshot":
            pass
        self.assertEqual([m["machine"] for m in message["machines"]], [made["id"]])
        self.assertEqual(message["machines"][0]["state"], "unknown", "never heard of is never idle")

    def test_a_client_that_stops_reading_costs_nothing(self):
        stuck = WebSocket(self.server, self.people["viewer"].token, buffer=4096)
        stuck.send('{"subscribe":["floor","programs","transfers"]}')
        for i in range(200):
            self.admin.ok("POST", "/folders", {"path": f"/f{i}"})
        ws = WebSocket(self.server, self.people["viewer"].token)
        self.addCleanup(ws.close)
        ws.send('{"subscribe":["floor"]}')
        self.assertEqual(ws.receive()["type"], "snapshot")
        self.alive()
        stuck.close()

    def test_nonsense_from_a_client(self):
        ws = WebSocket(self.server, self.admin.token)
        self.addCleanup(ws.close)
        ws.send("nonsense")
        self.assertEqual(ws.receive()["type"], "error")
        ws.send(b"x" * 200_000)   # above the limit: the server closes
        with self.assertRaises((ConnectionError, OSError, ValueError)):
            while True:
                ws.receive()
        self.alive()


class StartAndStop(unittest.TestCase):
    def setUp(self):
        self.server = Server().start()
        self.addCleanup(self.server.close)

    def second(self, *arguments):
        done = subprocess.run([SERVER, *arguments], capture_output=True, text=True, timeout=60)
        return done.returncode, done.stderr.strip()

    def test_port_in_use(self):
        with tempfile.TemporaryDirectory() as data:
            status, text = self.second("--data", data, "--port", str(self.server.port), "--agent-port", "0")
        self.assertEqual(status, 3, text)
        self.assertIn("in use", text)
        self.assertEqual(len([l for l in text.splitlines() if l.startswith("headstock-server:")]), 1)

    def test_data_folder_in_use(self):
        status, text = self.second("--data", self.server.data, "--port", "0", "--agent-port", "0")
        self.assertEqual(status, 4, text)
        self.assertIn("data folder in use", text)

    def test_damaged_database_is_refused_and_left_alone(self):
        self.assertEqual(self.server.stop(), 0)
        file = self.server.data / "headstock.db"
        file.write_bytes(b"this is not a database" * 1000)
        before = file.read_bytes()
        status, text = self.second("--data", self.server.data, "--port", "0", "--agent-port", "0")
        self.assertEqual(status, 5, text)
        self.assertEqual(file.read_bytes(), before)

    def test_plain_http_for_others_is_refused(self):
        with tempfile.TemporaryDirectory() as data:
            status, text = self.second("--data", data, "--address", "0.0.0.0", "--plain-http", "--port", "0", "--agent-port", "0")
        self.assertEqual(status, 6, text)
        self.assertIn("loopback", text)

    def test_first_sign_in_is_kept_secret_and_forgotten(self):
        file = self.server.data / "first-sign-in"
        self.assertEqual(stat.S_IMODE(file.stat().st_mode), 0o600)
        password = self.server.first_password()
        self.assertIn(password, "\n".join(self.server.greeting))
        admin = Client(self.server).sign_in("admin", password)
        admin.ok("POST", "/session/password", {"old": password, "new": "quite another 1"})
        until(lambda: not file.exists(), "the first sign-in is forgotten", 30)
        self.assertEqual(self.server.stop(), 0)
        again = Server(data=self.server.data).start()
        self.addCleanup(again.stop)
        self.assertNotIn("password", "\n".join(again.greeting))
        Client(again).sign_in("admin", "quite another 1")

    def test_both_signals_stop_cleanly(self):
        self.assertEqual(self.server.stop(signal.SIGINT), 0)

    def test_killed_at_any_moment_keeps_what_was_said_stored(self):
        admin = self.server.administrator()
        up = admin.upload("kept.nc", PROGRAM)
        token = admin.token
        self.server.stop(signal.SIGKILL)
        again = Server(data=self.server.data).start()
        self.addCleanup(again.stop)
        content = Client(again, token).ok("GET", f"/programs/{up['program']['id']}/revisions/1/content")
        self.assertEqual(content, PROGRAM.encode())

    def test_version(self):
        done = subprocess.run([SERVER, "--version"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stdout, r"^headstock-server \d+\.\d+\.\d+")


class Tls(unittest.TestCase):
    def test_own_certificate(self):
        import ssl
        server = Server(arguments=["--tls"]).start()
        self.addCleanup(server.close)
        self.assertTrue(any("https://" in line for line in server.greeting))
        authority = next(p for p in (server.data / "pki").iterdir() if p.name.startswith("ca") and p.suffix in (".pem", ".crt"))
        context = ssl.create_default_context(cafile=authority)
        with context.wrap_socket(server.raw(), server_hostname="localhost") as s:
            s.sendall(b"GET /api/v1/health HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
            self.assertIn(b"200 OK", s.recv(65536))
        with server.raw() as s:   # plain HTTP at a TLS port
            s.sendall(b"GET / HTTP/1.1\r\n\r\n")
            try:
                self.assertNotIn(b"200", s.recv(1000))
            except ConnectionError:
                pass


class CommandLine(WithServer):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.home = pathlib.Path(self.folder.name)

    def run_client(self, *arguments, status=0, stdin=None):
        done = subprocess.run([CLIENT, *map(str, arguments)], capture_output=True, text=True, input=stdin, timeout=120,
                              env={"HOME": str(self.home), "LANG": "C", "PATH": os.environ["PATH"]})
        self.assertEqual(done.returncode, status, (arguments, done.stdout, done.stderr))
        return done

    def sign_in(self, role="setter"):
        self.run_client("login", "--server", f"http://127.0.0.1:{self.server.port}", "--user", "t_" + role, "--password-file", "-",
                        stdin="a good Passw0rd\n")

    def test_sign_in_is_kept_in_a_private_file(self):
        self.assertIn("login", self.run_client("machines", status=4).stderr)
        self.sign_in()
        file = self.home / ".config" / "headstock" / "session"
        self.assertEqual(stat.S_IMODE(file.stat().st_mode), 0o600)
        self.run_client("machines")
        self.run_client("logout")
        self.run_client("machines", status=4)

    def test_wrong_password(self):
        done = self.run_client("login", "--server", f"http://127.0.0.1:{self.server.port}", "--user", "nobody", "--password-file", "-", stdin="x\n", status=4)
        self.assertNotIn("Traceback", done.stderr)

    def test_programs_go_up_and_come_back(self):
        self.sign_in()
        file = self.home / "O2001.nc"
        file.write_text(PROGRAM)
        made = json.loads(self.run_client("--json", "programs", "put", file, "--folder", "/shafts", "--note", "first").stdout)
        self.assertTrue(made["created"])
        file.write_text(PROGRAM.replace("F0.2", "F0.15"))
        self.run_client("programs", "put", file, "--folder", "/shafts", "--note", "slower")
        self.assertIn("/shafts/O2001.nc", self.run_client("programs", "list").stdout)
        self.assertEqual(self.run_client("programs", "get", "/shafts/O2001.nc", "--revision", "1").stdout, PROGRAM)
        self.assertIn("[feed_speed]", self.run_client("programs", "diff", "O2001.nc").stdout)
        self.assertIn("/shafts", self.run_client("programs", "folders").stdout)
        self.assertIn("slower", self.run_client("programs", "revisions", "O2001.nc").stdout)
        self.run_client("programs", "get", "nothing.nc", status=2)

    def test_refusals_in_both_languages(self):
        self.sign_in("viewer")
        file = self.home / "O1.nc"
        file.write_text(PROGRAM)
        self.assertIn("role", self.run_client("programs", "put", file, status=2).stderr)
        self.assertRegex(self.run_client("--lang", "zh", "programs", "put", file, status=2).stderr, "权限|无权")

    def test_a_machine_that_is_not_there_says_so(self):
        self.admin.ok("POST", "/machines", {"name": "CLI lathe", "profile": "gsk-2000tc"})
        self.sign_in("operator")
        done = self.run_client("hold", "CLI lathe", status=2)
        self.assertIn("not connected", done.stderr)
        self.run_client("hold", "no such", status=2)
        self.assertIn("unknown", self.run_client("machines").stdout)

    def test_watch_shows_the_floor(self):
        self.sign_in()
        done = self.run_client("--json", "watch", "--events", "1")
        self.assertEqual(json.loads(done.stdout.splitlines()[0])["type"], "snapshot")

    def test_nobody_listening(self):
        self.run_client("login", "--server", "http://127.0.0.1:1", "--user", "x", "--password-file", "-", stdin="x\n", status=3)


if __name__ == "__main__":
    unittest.main()
