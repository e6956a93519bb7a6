"""What reaches the server's ports from bad neighbours: each closes only its own connection and is told why."""
import os
import socket
import ssl
import struct
import subprocess

import parts
from shop import ApiError, Client, Process, Shop, ShopTest, eventually, program


def run_to_end(arguments, log):
    process = Process(arguments, log)
    status = process.child.wait(timeout=60)
    return status, process.text()


class StartUp(ShopTest):
    def server(self, folder, port, agent_port):
        return run_to_end([program("headstock-server"), "--data", folder, "--port", str(port), "--agent-port",
                           str(agent_port)], os.path.join(self.shop.folder, "second.log"))

    def test_a_port_in_use_is_said_in_one_line(self):
        self.shop.start_server()
        status, text = self.server(os.path.join(self.shop.folder, "other"), self.shop.http_port, 0)
        self.assertNotEqual(status, 0)
        self.assertIn(str(self.shop.http_port), text)
        self.assertIn("in use", text.lower())

    def test_a_data_folder_in_use_is_refused(self):
        self.shop.start_server()
        status, text = self.server(os.path.join(self.shop.folder, "server"), 0, 0)
        self.assertNotEqual(status, 0)
        self.assertIn("in use", text.lower())
        self.assertTrue(self.shop.admin.get("/machines") is not None)

    def test_a_corrupt_database_is_refused_and_left_alone(self):
        self.shop.start_server()
        self.shop.upload("O1", parts.LATHE)
        self.shop.server.stop()
        folder = os.path.join(self.shop.folder, "server")
        databases = [name for name in os.listdir(folder) if name.endswith((".db", ".sqlite"))]
        self.assertEqual(len(databases), 1, os.listdir(folder))
        path = os.path.join(folder, databases[0])
        with open(path, "r+b") as file:
            file.seek(0)
            file.write(b"this is not a database, and it never was one at all.....")
        with open(path, "rb") as file:
            before = file.read()
        status, text = self.server(folder, 0, 0)
        self.assertNotEqual(status, 0)
        self.assertRegex(text.lower(), "corrupt|damaged|not a database")
        with open(path, "rb") as file:
            self.assertEqual(file.read(), before, "nothing was touched")


class AgentPort(ShopTest):
    def setUp(self):
        super().setUp()
        self.shop.start_server()

    def tls(self):
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.check_hostname = False
        context.verify_mode = ssl.CERT_NONE
        context.set_alpn_protocols(["headstock/1"])
        return context.wrap_socket(socket.create_connection(("127.0.0.1", self.shop.agent_port), timeout=30))

    def closed(self, connection):
        """The other side closes; whatever it says before is returned."""
        said = b""
        try:
            while data := connection.recv(65536):
                said += data
        except (OSError, ssl.SSLError):
            pass
        return said

    def test_a_frame_of_two_gigabytes_closes_that_connection(self):
        with self.tls() as connection:
            connection.sendall(struct.pack(">4sBBHIII", b"HSTK", 1, 1, 0, 0, 2**31, 0))
            self.closed(connection)
        self.assertLess(self.shop.server.peak_memory_mib(), 300)
        self.assertTrue(self.shop.admin.get("/machines") is not None)

    def test_garbage_instead_of_tls(self):
        with socket.create_connection(("127.0.0.1", self.shop.agent_port), timeout=30) as connection:
            connection.sendall(b"GET / HTTP/1.0\r\n\r\n" + bytes(range(256)) * 64)
            self.closed(connection)
        with self.tls() as connection:
            connection.sendall(os.urandom(4096))
            self.closed(connection)
        self.assertTrue(self.shop.admin.get("/machines") is not None)

    def test_a_wrong_token_is_refused_and_said(self):
        agent = self.shop.agent("Lathe 1", "fanuc-0i-t")
        good = agent.token
        head, secret, fingerprint = good.split("-", 2)
        agent.token = "-".join((head, ("A" if secret[0] != "A" else "B") + secret[1:], fingerprint))
        agent.start(wait=False)
        eventually(lambda: "token" in agent.process.text().lower(), "the agent's log names the token")
        self.assertFalse(agent.live()["connected"])
        agent.process.stop()
        agent.token = good
        agent.start()
        self.assertTrue(agent.live()["connected"])

    def test_two_agents_with_one_identity(self):
        agent = self.shop.agent("Lathe 1", "fanuc-0i-t").start()
        twin = os.path.join(self.shop.folder, "twin")
        subprocess.run(["cp", "-r", agent.folder, twin], check=True)
        arguments = [word.replace(agent.folder, twin) for word in agent.arguments()]
        second = Process(arguments, os.path.join(self.shop.folder, "twin.log"))
        self.shop.processes.append(second)
        eventually(lambda: "identity" in second.text().lower(), "the second is told why it is refused")
        self.assertTrue(agent.live()["connected"], "the first goes on")
        self.assertIn("identity", self.shop.server.text().lower())

    def test_a_certificate_of_a_foreign_shop(self):
        agent = self.shop.agent("Lathe 1", "fanuc-0i-t").start()
        agent.process.stop()
        stranger = Shop()
        self.addCleanup(stranger.close)
        stranger.start_server()
        foreign = Process(agent.arguments(port=stranger.agent_port), os.path.join(stranger.folder, "foreign.log"))
        stranger.processes.append(foreign)
        eventually(lambda: "certificate" in foreign.text().lower(), "the agent's log names the certificate")
        self.assertEqual(stranger.admin.get("/machines")["items"], [])


class Roles(ShopTest):
    def test_a_role_that_tries_what_it_may_not(self):
        self.shop.start_server()
        made = self.shop.upload("O1", parts.LATHE)["program"]["id"]
        machine = self.shop.admin.post("/machines", {"name": "Lathe 1", "profile": "fanuc-0i-t"})["id"]
        clients = {}
        for role in ("viewer", "operator", "programmer", "setter"):
            self.shop.admin.post("/users", {"user": role, "name": role, "role": role, "password": "correct horse " + role,
                                              "must_change_password": False})
            clients[role] = Client(self.shop.admin.base).sign_in(role, "correct horse " + role)
        attempts = {
            "viewer": [("POST", f"/machines/{machine}/commands", {"action": "cycle_start"}),
                       ("POST", "/folders", {"path": "x"}), ("DELETE", f"/programs/{made}", None)],
            "operator": [("DELETE", f"/programs/{made}", None), ("POST", "/distributions", {})],
            "programmer": [("POST", f"/programs/{made}/revisions/1/release", {"why": "no right"})],
            "setter": [("POST", "/machines", {"name": "x", "profile": "fanuc-0i-t"}), ("GET", "/users", None),
                       ("POST", "/users", {"user": "evil", "role": "administrator", "password": "correct horse x"})],
        }
        for role, calls in attempts.items():
            for method, path, body in calls:
                with self.subTest(role=role, path=path):
                    with self.assertRaises(ApiError) as refused:
                        clients[role].call(method, path, body)
                    self.assertEqual(refused.exception.status, 403)
        with self.assertRaises(ApiError) as refused:
            Client(self.shop.admin.base).get("/machines")
        self.assertEqual(refused.exception.status, 401)
        revisions = self.shop.admin.get(f"/programs/{made}/revisions")["items"]
        self.assertEqual([r["released"] for r in revisions], [None])
