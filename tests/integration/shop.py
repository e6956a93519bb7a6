"""A shop on this machine for the tests: a real server process, real agent processes, and the ways people reach them.

Nothing here sleeps and hopes: `eventually` waits for a condition and fails with the last thing it saw.
"""
import json
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest
import urllib.error
import urllib.parse
import urllib.request

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "../.."))
BIN = os.environ.get("HEADSTOCK_BIN", os.path.join(ROOT, "build/release/bin"))
# A test that waits longer than this has failed; nothing is judged by how long it took below it.
PATIENCE_S = 60.0
ADMIN_PASSWORD = "turn every handle 1"
MACHINE_FILES = {"fanuc-0i-t": "lathe-1.toml", "fanuc-0i-m": "mill-1.toml", "gsk-2000tc": "lathe-2.toml"}


def program(name):
    return os.path.join(BIN, name)


def eventually(condition, what, patience_s=PATIENCE_S):
    """The first true value of `condition()`; fails naming `what` and the last value or error seen."""
    deadline = time.monotonic() + patience_s
    last = None
    while True:
        try:
            last = condition()
            if last:
                return last
        except (OSError, ApiError, KeyError, TypeError) as problem:
            last = problem
        if time.monotonic() > deadline:
            raise AssertionError(f"never happened: {what}; last seen: {last!r}")
        time.sleep(0.02)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class ApiError(Exception):
    def __init__(self, status, body):
        self.status = status
        self.reason = None      # the machine's own reason, when it was the machine that refused
        try:
            answer = json.loads(body)
            self.error, self.reason = answer["error"], answer.get("reason")
        except (ValueError, KeyError, TypeError):
            self.error = {"code": None, "raw": body[:300]}
        super().__init__(f"{status} {self.error}")

    @property
    def code(self):
        return self.error.get("code")


class Client:
    """The REST interface as a tool uses it."""

    def __init__(self, base):
        self.base = base
        self.token = None

    def call(self, method, path, body=None, raw=None, query=None, timeout=PATIENCE_S):
        url = self.base + "/api/v1" + path
        if query:
            url += "?" + urllib.parse.urlencode(query)
        data, headers = raw, {}
        if body is not None:
            data, headers["Content-Type"] = json.dumps(body).encode(), "application/json"
        elif raw is not None:
            headers["Content-Type"] = "application/octet-stream"
        if self.token:
            headers["Authorization"] = "Bearer " + self.token
        request = urllib.request.Request(url, data=data, method=method, headers=headers)
        try:
            with urllib.request.urlopen(request, timeout=timeout) as answer:
                content = answer.read()
                kind = answer.headers.get("Content-Type", "")
                return json.loads(content) if content and "json" in kind else content
        except urllib.error.HTTPError as problem:
            raise ApiError(problem.code, problem.read().decode(errors="replace")) from None

    def get(self, path, **query):
        return self.call("GET", path, query=query)

    def post(self, path, body=None, **query):
        return self.call("POST", path, body={} if body is None else body, query=query)

    def sign_in(self, user, password):
        self.token = self.call("POST", "/session", {"user": user, "password": password})["token"]
        return self


class Process:
    """A child process with its output in a file."""

    def __init__(self, arguments, log):
        self.log = log
        with open(log, "ab") as out:
            self.child = subprocess.Popen(arguments, stdin=subprocess.DEVNULL, stdout=out, stderr=out)

    def running(self):
        return self.child.poll() is None

    def kill9(self):
        self.child.kill()
        self.child.wait()

    def stop(self):
        """SIGTERM; the exit status."""
        if self.running():
            self.child.send_signal(signal.SIGTERM)
            try:
                return self.child.wait(timeout=PATIENCE_S)
            except subprocess.TimeoutExpired:
                self.kill9()
                raise AssertionError(f"did not stop on SIGTERM: {self.log}")
        return self.child.returncode

    def peak_memory_mib(self):
        with open(f"/proc/{self.child.pid}/status", encoding="ascii") as status:
            for line in status:
                if line.startswith("VmHWM"):
                    return int(line.split()[1]) / 1024
        return 0.0

    def text(self):
        with open(self.log, encoding="utf-8", errors="replace") as log:
            return log.read()


class Agent:
    """One machine: its data folder, its process, its local panel."""

    def __init__(self, shop, name, profile, machine_file=None, extra=()):
        self.shop, self.name, self.profile = shop, name, profile
        self.folder = os.path.join(shop.folder, name.replace(" ", "-").lower())
        os.makedirs(self.folder, exist_ok=True)
        self.machine_file = machine_file or os.path.join(ROOT, "deploy/machines", MACHINE_FILES[profile])
        self.extra = list(extra)
        self.process = None
        made = shop.admin.post("/machines", {"name": name, "profile": profile})
        self.id, self.token = made["id"], made["enrolment_token"]

    def arguments(self, port=None):
        arguments = [program("headstock-agent"), "--data", self.folder,
                     "--server", f"127.0.0.1:{port or self.shop.agent_port}", *self.extra]
        arguments += ["--machine", self.machine_file]
        if self.token:
            arguments += ["--enrol", self.token]
        return arguments

    def start(self, port=None, wait=True):
        self.process = Process(self.arguments(port), os.path.join(self.folder, "agent.log"))
        self.shop.processes.append(self.process)
        if wait:
            def connected():
                if not self.process.running():
                    raise AssertionError(f"{self.name} ended: {self.process.text()}")
                return self.live()["connected"]

            eventually(connected, f"{self.name} connected")
            self.token = None
        return self

    def live(self):
        return self.shop.admin.get(f"/machines/{self.id}")["live"]

    def panel(self, *words):
        done = subprocess.run([program("headstock-agent"), "panel", "--data", self.folder, *words],
                              capture_output=True, text=True, timeout=PATIENCE_S)
        if done.returncode:
            raise OSError(f"panel {words}: {done.stdout}{done.stderr}")
        return done.stdout

    def status(self):
        return json.loads(self.panel("status"))

    def arm(self):
        eventually(lambda: self.panel("arm") is not None, f"{self.name} armed at its panel")
        eventually(lambda: self.live()["remote_armed"], f"{self.name} seen armed")

    def command(self, action, value=0):
        return self.shop.admin.post(f"/machines/{self.id}/commands", {"action": action, "value": value})

    def parts(self):
        return self.live()["parts"]["count"]


class Shop:
    """A server and any number of agents in one temporary folder."""

    def __init__(self, keep=False):
        self.folder = tempfile.mkdtemp(prefix="headstock-test-")
        self.keep = keep or bool(os.environ.get("HEADSTOCK_KEEP"))
        self.http_port, self.agent_port = free_port(), free_port()
        self.processes = []
        self.changed = False
        self.server = None
        self.server_arguments = []
        self.admin = Client(f"http://127.0.0.1:{self.http_port}")

    def start_server(self, wait=True):
        self.server = Process([program("headstock-server"), "--data", os.path.join(self.folder, "server"),
                               "--port", str(self.http_port), "--agent-port", str(self.agent_port),
                               *self.server_arguments], os.path.join(self.folder, "server.log"))
        self.processes.append(self.server)
        if wait:
            eventually(lambda: self.server.running() and self.admin.call("GET", "/health"), "server answers")
            if not self.admin.token:
                user, password = self.first_sign_in()
                self.admin.sign_in(user, password)
                # The server lets the first administrator do nothing before that.
                self.admin.post("/session/password", {"old": password, "new": ADMIN_PASSWORD})
                self.changed = True
        return self

    def start_server_only(self):
        """Of a shop that has its people already: nobody is signed in."""
        self.start_server(wait=False)
        eventually(lambda: self.server.running() and self.admin.call("GET", "/health"), "server answers")

    def administrator(self):
        """User and password that hold now."""
        return ("admin", ADMIN_PASSWORD) if self.changed else self.first_sign_in()

    def person(self, user, role, name=None):
        """A client signed in as a new user who has chosen a password."""
        self.admin.post("/users", {"user": user, "name": name or user, "role": role, "password": "correct horse 1", "must_change_password": False})
        return Client(self.admin.base).sign_in(user, "correct horse 1")

    def first_sign_in(self):
        with open(os.path.join(self.folder, "server", "first-sign-in"), encoding="utf-8") as file:
            words = dict(line.split(":", 1) for line in file.read().splitlines() if ":" in line)
        return words["user"].strip(), words["password"].strip()

    def agent(self, name, profile, **more):
        return Agent(self, name, profile, **more)

    def upload(self, name, text, folder="", note="test"):
        raw = text if isinstance(text, bytes) else text.encode()
        return self.admin.call("POST", "/programs", raw=raw, query={"folder": folder, "name": name, "note": note})

    def check(self, program_id, revision, agent):
        """The server's check against the machine; a long one is a job, which is waited for."""
        path = f"/programs/{program_id}/revisions/{revision}/check"
        answer = self.admin.call("POST", path, {"machine": agent.id}, timeout=300)
        if "job" not in answer:
            return answer

        def ended():
            job = self.admin.get(f"/jobs/{answer['job']}")
            return job if job["state"] != "running" else None

        return eventually(ended, "check ended", 10 * PATIENCE_S)["result"]

    def release(self, program_id, revision, agent):
        """Checks against the machine and releases; returns the check."""
        check = self.check(program_id, revision, agent)
        self.admin.post(f"/programs/{program_id}/revisions/{revision}/release", {"why": "checked by the test"})
        return check

    def send(self, program_id, revision, agents):
        made = self.admin.post("/distributions", {"program": program_id, "revision": revision,
                                                  "machines": [agent.id for agent in agents]})

        def finished():
            seen = self.admin.get(f"/distributions/{made['id']}")
            transfers = seen["transfers"]
            return seen if all(t["state"] in ("done", "failed", "cancelled") for t in transfers) else None

        return eventually(finished, "distribution finished")

    def close(self):
        for process in self.processes:
            if process.running():
                process.kill9()
        if self.keep:
            print("kept:", self.folder)
        else:
            shutil.rmtree(self.folder, ignore_errors=True)


class ShopTest(unittest.TestCase):
    """A test case with a shop of its own, removed at the end; the logs are shown when it failed."""

    def setUp(self):
        self.shop = Shop()
        self.addCleanup(self.shop.close)

    def make_resident(self, agent, name, text):
        """Upload, check, release, send, select: the program waits for cycle start on the machine."""
        made = self.shop.upload(name, text)
        program_id, revision = made["program"]["id"], made["revision"]["number"]
        check = self.shop.release(program_id, revision, agent)
        self.assertTrue(check["ok"], check)
        sent = self.shop.send(program_id, revision, [agent])
        self.assertEqual(sent["transfers"][0]["state"], "done", sent)
        answer = self.shop.admin.post(f"/machines/{agent.id}/select", {"name": name})
        self.assertTrue(answer["accepted"], answer)
        return program_id, revision


class CuttingProxy:
    """TCP in the middle that can cut every connection at once, or after so many bytes toward the agent."""

    def __init__(self, target_port):
        self.target_port = target_port
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.cuts = 0
        self.bytes_down = 0
        self.lock = threading.Lock()
        self.pairs = []
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            try:
                near, _ = self.listener.accept()
            except OSError:
                return
            try:
                far = socket.create_connection(("127.0.0.1", self.target_port), timeout=5)
                far.settimeout(None)
            except OSError:
                near.close()
                continue
            with self.lock:
                self.pairs.append((near, far))
            threading.Thread(target=self.pump, args=(far, near, True), daemon=True).start()
            threading.Thread(target=self.pump, args=(near, far, False), daemon=True).start()

    def pump(self, source, sink, down):
        try:
            while data := source.recv(65536):
                if down:
                    self.bytes_down += len(data)
                sink.sendall(data)
        except OSError:
            pass
        for end in (source, sink):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def cut(self):
        with self.lock:
            pairs, self.pairs = self.pairs, []
        for pair in pairs:
            for end in pair:
                try:
                    end.shutdown(socket.SHUT_RDWR)
                    end.close()
                except OSError:
                    pass
        self.cuts += bool(pairs)
        return bool(pairs)

    def close(self):
        self.listener.close()
        self.cut()
