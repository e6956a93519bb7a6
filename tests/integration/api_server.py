"""A real headstock-server for a test: started on free ports with a data folder of its own, stopped at the end."""

import http.client
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("HEADSTOCK_BIN", ROOT / "build" / "release" / "bin"))
SERVER = BIN / "headstock-server"
CLIENT = BIN / "headstock"


class Server:
    def __init__(self, data=None, arguments=()):
        self.folder = None if data else tempfile.mkdtemp(prefix="headstock-test-")
        self.data = pathlib.Path(data or self.folder)
        self.arguments = list(arguments)
        self.process = None
        self.port = None

    def start(self):
        self.log = open(self.data.parent / (self.data.name + ".log"), "ab")
        self.process = subprocess.Popen(
            [SERVER, "--data", self.data, "--port", "0", "--agent-port", "0", *self.arguments],
            stdout=subprocess.PIPE, stderr=self.log, text=True)
        self.greeting = []
        for line in self.process.stdout:
            self.greeting.append(line.rstrip("\n"))
            if line.startswith("open"):
                self.port = int(re.search(r":(\d+)$", line.strip()).group(1))
            if line.strip() == "ready":
                return self
        raise RuntimeError(f"the server did not start: {self.process.wait()}: " + pathlib.Path(self.log.name).read_text())

    def stop(self, sig=signal.SIGTERM, timeout=30):
        if self.process and self.process.poll() is None:
            self.process.send_signal(sig)
            self.process.wait(timeout)
        if self.process:
            self.process.stdout.close()
            self.log.close()
            return self.process.returncode

    def close(self):
        self.stop()
        if self.folder:
            shutil.rmtree(self.folder, ignore_errors=True)
            pathlib.Path(self.folder + ".log").unlink(missing_ok=True)

    def first_password(self):
        text = (self.data / "first-sign-in").read_text()
        return re.search(r"^password: (.*)$", text, re.M).group(1)

    def administrator(self):
        """Signed in as the first administrator, who has chosen a password: before that the server lets nobody do more."""
        first = self.first_password()
        admin = Client(self).sign_in("admin", first)
        admin.ok("POST", "/session/password", {"old": first, "new": "turn every handle 1"})
        return admin

    def raw(self, timeout=20):
        return socket.create_connection(("127.0.0.1", self.port), timeout)


class Client:
    """One person at the interface. Answers are (status, parsed JSON or bytes, headers)."""

    def __init__(self, server, token=None, cookie=None):
        self.server, self.token, self.cookie = server, token, cookie

    def call(self, method, path, body=None, headers=None, raw=None, prefix="/api/v1"):
        connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=60)
        fields = dict(headers or {})
        if self.token:
            fields.setdefault("Authorization", "Bearer " + self.token)
        if self.cookie:
            fields.setdefault("Cookie", "headstock_session=" + self.cookie)
        data = raw
        if body is not None:
            data = json.dumps(body).encode()
            fields.setdefault("Content-Type", "application/json")
        try:
            connection.request(method, prefix + path, data, fields)
            answer = connection.getresponse()
            content = answer.read()
            if answer.getheader("Content-Type", "").startswith("application/json"):
                content = json.loads(content)
            return answer.status, content, answer.headers
        finally:
            connection.close()

    def ok(self, method, path, body=None, **more):
        status, content, _ = self.call(method, path, body, **more)
        assert 200 <= status < 300, (method, path, status, content)
        return content

    def sign_in(self, user, password):
        answer = self.ok("POST", "/session", {"user": user, "password": password})
        self.token = answer["token"]
        return self

    def upload(self, name, text, folder="/", note=""):
        from urllib.parse import quote
        raw = text if isinstance(text, bytes) else text.encode()
        return self.ok("POST", f"/programs?folder={quote(folder, safe='')}&name={quote(name)}&note={quote(note)}", raw=raw,
                       headers={"Content-Type": "application/octet-stream"})
