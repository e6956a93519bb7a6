"""Who is told of alarms: a real mail server and a real webhook, over sockets; acknowledgement, escalation, one event."""
import email
import email.header
import hashlib
import hmac
import http.server
import json
import socket
import threading

from shop import ApiError, ShopTest, eventually

PROGRAM = ("O1666", "O1666\nG21 G98\nG00 X100. Z50.\nG01 Z-9999. F3000.\nM30\n%\n")


class MailServer:
    """SMTP as far as a client sees it; `refuse` makes it answer 451 to every message."""

    def __init__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.messages, self.refuse, self.tries = [], False, 0
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self):
        while True:
            try:
                peer, _ = self.listener.accept()
            except OSError:
                return
            threading.Thread(target=self.talk, args=(peer,), daemon=True).start()

    def talk(self, peer):
        file = peer.makefile("rwb")

        def say(text):
            file.write(text.encode() + b"\r\n")
            file.flush()

        say("220 test")
        to = []
        while line := file.readline():
            word = line.strip().upper()
            if word.startswith(b"EHLO"):
                say("250 test")
            elif word.startswith(b"RCPT"):
                to.append(line.decode().split("<")[1].split(">")[0])
                say("250 ok")
            elif word == b"DATA":
                say("354 go on")
                text = b""
                while (line := file.readline()) != b".\r\n":
                    text += line
                self.tries += 1
                if self.refuse:
                    say("451 not now")
                else:
                    self.messages.append((to, email.message_from_bytes(text)))
                    say("250 taken")
            elif word == b"QUIT":
                say("221 bye")
                break
            else:
                say("250 ok")
        peer.close()


class Webhook(http.server.ThreadingHTTPServer):
    def __init__(self):
        self.calls = []
        hook = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                body = self.rfile.read(int(self.headers["Content-Length"]))
                hook.calls.append((self.headers, body))
                self.send_response(204)
                self.end_headers()

            def log_message(self, *_):
                pass

        super().__init__(("127.0.0.1", 0), Handler)
        threading.Thread(target=self.serve_forever, daemon=True).start()

    @property
    def url(self):
        return f"http://127.0.0.1:{self.server_address[1]}/hook"


def subject(message):
    return "".join(part.decode(code or "ascii") if isinstance(part, bytes) else part
                   for part, code in email.header.decode_header(message["Subject"]))


class AlarmRules(ShopTest):
    def setUp(self):
        super().setUp()
        self.shop.start_server()
        self.admin = self.shop.admin
        self.mail, self.hook = MailServer(), Webhook()
        self.addCleanup(self.hook.shutdown)
        self.admin.call("PATCH", "/settings/messages",
                        {"mail_url": f"smtp://127.0.0.1:{self.mail.port}", "mail_from": "Headstock <shop@example.test>",
                         "webhook_secret": "sesame", "link": "https://shop.example.test"})

    def machine_with_a_bad_program(self):
        agent = self.shop.agent("Lathe 1", "fanuc-0i-t").start()
        name, text = PROGRAM
        path = f"{self.shop.folder}/{name}"
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
        agent.panel("load", path)
        agent.panel("select", name)
        return agent

    def raise_alarm(self, agent):
        agent.panel("start")
        eventually(lambda: agent.live()["alarms"], "alarm")

    def clear_alarm(self, agent):
        agent.panel("reset")
        eventually(lambda: not agent.live()["alarms"], "alarm cleared")

    def events(self, **query):
        return self.admin.get("/alarm-events", **query)["items"]

    def test_mail_and_webhook_once_for_an_alarm_that_comes_back(self):
        agent = self.machine_with_a_bad_program()
        self.admin.post("/alarm-rules", {"name": "overtravel", "code": "OT*", "email": "a@example.test, b@example.test",
                                         "webhook": self.hook.url, "again_after_s": 3600})
        self.admin.post("/alarm-rules", {"name": "something else", "code": "PS*", "email": "never@example.test"})
        self.raise_alarm(agent)
        eventually(lambda: len(self.mail.messages) == 2 and len(self.hook.calls) == 1, "told everybody")
        self.assertEqual(sorted(to[0] for to, _ in self.mail.messages), ["a@example.test", "b@example.test"])
        message = self.mail.messages[0][1]
        self.assertIn("Lathe 1", subject(message))
        text = message.get_payload(decode=True).decode()
        self.assertIn("Machine / 机床: Lathe 1", text)
        self.assertIn("https://shop.example.test", text)
        headers, body = self.hook.calls[0]
        self.assertEqual(headers["X-Headstock-Signature"], "sha256=" + hmac.new(b"sesame", body, hashlib.sha256).hexdigest())
        facts = json.loads(body)
        self.assertEqual((facts["machine"]["name"], facts["step"]), ("Lathe 1", "first"))
        self.assertTrue(facts["code"].startswith("OT"))
        # The same alarm again, soon: the same event, nobody is bothered again.
        self.clear_alarm(agent)
        eventually(lambda: self.events()[0]["cleared"], "the event ends with the alarm")
        self.raise_alarm(agent)
        eventually(lambda: self.events()[0]["times"] == 2, "seen as the same")
        self.assertEqual(len(self.events()), 1)
        self.assertEqual(len(self.mail.messages), 2)
        # Acknowledged once, by somebody with a name.
        event = self.events(open="true")[0]["id"]
        self.assertEqual(self.admin.post(f"/alarm-events/{event}/acknowledge", {"note": "on my way"})["acknowledged"]["by"], "admin")
        self.assertEqual(self.events(open="true"), [])
        with self.assertRaises(ApiError) as again:
            self.admin.post(f"/alarm-events/{event}/acknowledge", {})
        self.assertEqual(again.exception.code, "already_decided")

    def test_nobody_answers_so_the_next_in_line_hears_of_it(self):
        agent = self.machine_with_a_bad_program()
        self.admin.post("/alarm-rules", {"name": "r", "email": "first@example.test", "escalate_after_s": 1, "escalate_email": "boss@example.test"})
        self.raise_alarm(agent)
        eventually(lambda: [to for to, _ in self.mail.messages] == [["first@example.test"], ["boss@example.test"]], "escalated")
        self.assertTrue(subject(self.mail.messages[1][1]).startswith("[!!]"))
        self.assertTrue(self.events()[0]["escalated"])

    def test_a_mail_server_that_refuses_is_tried_again_later(self):
        agent = self.machine_with_a_bad_program()
        self.mail.refuse = True
        self.admin.post("/alarm-rules", {"name": "r", "email": "a@example.test"})
        self.raise_alarm(agent)
        event = eventually(lambda: self.events(), "event")[0]["id"]
        notices = lambda: self.admin.get(f"/alarm-events/{event}/notices")["items"]
        eventually(lambda: notices()[0]["attempts"] == 1, "tried")
        self.assertEqual(notices()[0]["state"], "waiting")
        self.assertTrue(notices()[0]["problem"])
        # It waits over a restart of the server, too.
        self.shop.server.kill9()
        self.shop.start_server()
        self.assertEqual(notices()[0]["state"], "waiting")

    def test_bad_rules_and_settings_are_refused(self):
        for rule, field in (({"name": ""}, "name"), ({"name": "r"}, "email"), ({"name": "r", "email": "nobody"}, "email"),
                            ({"name": "r", "webhook": "file:///etc/passwd"}, "webhook"),
                            ({"name": "r", "email": "a@b.c", "escalate_after_s": 5}, "escalate_email"),
                            ({"name": "r", "email": "a@b.c", "machine": 99}, "machine")):
            with self.assertRaises(ApiError) as refused:
                self.admin.post("/alarm-rules", rule)
            self.assertEqual(refused.exception.error["where"], field, refused.exception)
        with self.assertRaises(ApiError):
            self.admin.call("PATCH", "/settings/messages", {"mail_url": "http://x"})
        shown = self.admin.get("/settings/messages")
        self.assertTrue(shown["webhook_secret_set"])
        self.assertNotIn("sesame", json.dumps(shown))
        self.assertTrue(self.admin.post("/settings/messages/test", {"kind": "email", "target": "x@example.test"})["delivered"])
        self.assertEqual(len(self.mail.messages), 1)
