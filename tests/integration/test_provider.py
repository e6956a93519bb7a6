"""Signing in through an OpenID Connect provider: authorization code with PKCE against a small provider of the test."""
import base64
import hashlib
import http.client
import http.server
import json
import os
import subprocess
import threading
import time
import urllib.parse

from shop import ApiError, Client, ShopTest


def encoded(value):
    return base64.urlsafe_b64encode(value).rstrip(b"=").decode()


class SigningKey:
    """An RSA key of the provider in a file."""

    def __init__(self, folder, name):
        self.name, self.file = name, os.path.join(folder, name + ".pem")
        subprocess.run(["openssl", "genpkey", "-algorithm", "RSA", "-pkeyopt", "rsa_keygen_bits:2048", "-out", self.file],
                       check=True, capture_output=True)

    def published(self):
        told = subprocess.run(["openssl", "rsa", "-in", self.file, "-noout", "-modulus"], check=True, capture_output=True, text=True).stdout
        return {"kty": "RSA", "use": "sig", "alg": "RS256", "kid": self.name, "e": "AQAB",
                "n": encoded(bytes.fromhex(told.strip().split("=")[1]))}

    def token(self, claims, header=None):
        text = ".".join(encoded(json.dumps(part).encode()) for part in (header or {"alg": "RS256", "kid": self.name}, claims))
        signed = subprocess.run(["openssl", "dgst", "-sha256", "-sign", self.file], input=text.encode(), check=True, capture_output=True)
        return text + "." + encoded(signed.stdout)


class Provider(http.server.ThreadingHTTPServer):
    """Answers discovery, keys and the token endpoint; the test itself is the browser at the authorization endpoint."""

    def __init__(self, folder):
        self.codes, self.claims, self.header = {}, {}, None
        self.key = SigningKey(folder, "key-1")
        self.published = [self.key.published()]
        provider = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def answer(self, status, body):
                data = json.dumps(body).encode()
                self.send_response(status)
                self.send_header("Content-Type", "application/json")
                self.send_header("Content-Length", str(len(data)))
                self.end_headers()
                self.wfile.write(data)

            def do_GET(self):
                if self.path == "/keys":
                    return self.answer(200, {"keys": provider.published})
                self.answer(200, {"issuer": provider.issuer, "authorization_endpoint": provider.issuer + "/authorize",
                                  "token_endpoint": provider.issuer + "/token", "jwks_uri": provider.issuer + "/keys"})

            def do_POST(self):
                form = dict(urllib.parse.parse_qsl(self.rfile.read(int(self.headers["Content-Length"])).decode()))
                begun = provider.codes.pop(form.get("code"), None)
                wanted = "Basic " + base64.b64encode(b"headstock:sesame").decode()
                right = begun and encoded(hashlib.sha256(form["code_verifier"].encode()).digest()) == begun["code_challenge"]
                if not right or self.headers.get("Authorization") != wanted or form["redirect_uri"] != begun["redirect_uri"]:
                    return self.answer(400, {"error": "invalid_grant"})
                claims = {"iss": provider.issuer, "aud": "headstock", "exp": time.time() + 60, "nonce": begun["nonce"], "sub": "42",
                          "preferred_username": "li.wei", "name": "李伟", **provider.claims}
                self.answer(200, {"id_token": provider.key.token(claims, provider.header)})

            def log_message(self, *_):
                pass

        super().__init__(("127.0.0.1", 0), Handler)
        threading.Thread(target=self.serve_forever, daemon=True).start()

    @property
    def issuer(self):
        return f"http://127.0.0.1:{self.server_address[1]}"


class ProviderSignIn(ShopTest):
    def setUp(self):
        super().setUp()
        self.shop.start_server()
        self.provider = Provider(self.shop.folder)
        self.addCleanup(self.provider.shutdown)
        self.settings = {"issuer": self.provider.issuer, "client_id": "headstock", "client_secret": "sesame", "label": "Works account",
                         "create": True, "role": "operator"}
        self.shop.admin.call("PATCH", "/settings/provider", self.settings)

    def ask(self, path, cookie=""):
        connection = http.client.HTTPConnection("127.0.0.1", self.shop.http_port, timeout=30)
        connection.request("GET", "/api/v1" + path, headers={"Cookie": cookie} if cookie else {})
        answer = connection.getresponse()
        body = answer.read()
        connection.close()
        return answer, body

    def begin(self):
        answer, _ = self.ask("/session/provider")
        self.assertEqual(answer.status, 302)
        asked = dict(urllib.parse.parse_qsl(urllib.parse.urlsplit(answer.getheader("Location")).query))
        self.assertEqual((asked["response_type"], asked["client_id"], asked["code_challenge_method"]), ("code", "headstock", "S256"))
        cookie = answer.getheader("Set-Cookie").split(";")[0]
        code = "code-" + asked["state"]
        self.provider.codes[code] = asked
        return f"/session/provider/return?state={asked['state']}&code={code}", cookie

    def sign_in(self):
        path, cookie = self.begin()
        answer, body = self.ask(path, cookie)
        if answer.status != 200:
            return json.loads(body)["error"]["code"]
        cookies = [value for name, value in answer.getheaders() if name.lower() == "set-cookie"]
        session = next(value for value in cookies if value.startswith("headstock_session="))
        self.assertIn("HttpOnly", session)
        self.assertIn("SameSite=Strict", session)
        client = Client(self.shop.admin.base)
        client.token = session.split(";")[0].split("=", 1)[1]
        return client.get("/session")

    def test_a_new_person_comes_in_and_is_the_same_the_next_time(self):
        self.assertEqual(self.shop.admin.get("/sign-in-provider"), {"enabled": True, "label": "Works account"})
        person = self.sign_in()
        self.assertEqual((person["user"], person["name"], person["role"]), ("li.wei", "李伟", "operator"))
        self.provider.claims = {"preferred_username": "renamed"}
        self.assertEqual(self.sign_in()["user"], "li.wei", "known by issuer and subject, not by name")
        with self.assertRaises(ApiError):
            Client(self.shop.admin.base).sign_in("li.wei", "")
        user = next(u for u in self.shop.admin.get("/users")["items"] if u["user"] == "li.wei")
        self.shop.admin.call("PATCH", f"/users/{user['id']}", {"disabled": True})
        self.assertEqual(self.sign_in(), "wrong_sign_in")

    def test_a_name_that_is_taken_is_not_taken_over(self):
        self.provider.claims = {"preferred_username": "admin"}
        person = self.sign_in()
        self.assertEqual((person["user"], person["role"]), ("admin.2", "operator"))

    def test_strangers_stay_out_when_the_shop_says_so(self):
        self.shop.admin.call("PATCH", "/settings/provider", {**self.settings, "create": False})
        self.assertEqual(self.sign_in(), "unknown_person")

    def test_only_a_published_key_signs_people_in(self):
        right, stranger = self.provider.key, SigningKey(self.shop.folder, "stranger")
        stranger.name = right.name
        self.provider.key = stranger
        self.assertEqual(self.sign_in(), "provider_failed", "the right name on another key")
        self.provider.key = right
        for header in ({"alg": "none"}, {"alg": "HS256", "kid": "key-1"}, {"alg": "RS256", "kid": "key-9"}):
            self.provider.header = header
            self.assertEqual(self.sign_in(), "provider_failed", header)
        self.provider.header = None
        self.assertEqual(self.sign_in()["user"], "li.wei")
        # The provider changes its key: the new one holds at once, the old one no longer.
        new = SigningKey(self.shop.folder, "key-2")
        self.provider.published = [new.published()]
        self.assertEqual(self.sign_in(), "provider_failed", "withdrawn")
        self.provider.key = new
        self.assertEqual(self.sign_in()["user"], "li.wei")

    def test_what_is_not_right_is_refused(self):
        for claims in ({"iss": "https://other.example"}, {"aud": "another"}, {"exp": time.time() - 3600}, {"nonce": "old"}, {"sub": ""},
                       {"aud": ["headstock", "other"]}):
            self.provider.claims = claims
            self.assertEqual(self.sign_in(), "provider_failed", claims)
        self.provider.claims = {}
        path, cookie = self.begin()
        self.assertEqual(self.ask(path)[0].status, 401, "another browser")
        self.assertEqual(self.ask(path, cookie)[0].status, 200)
        self.assertEqual(self.ask(path, cookie)[0].status, 401, "twice")
        for issuer in ("http://example.test", "ftp://x", "javascript:alert(1)"):
            with self.assertRaises(ApiError):
                self.shop.admin.call("PATCH", "/settings/provider", {**self.settings, "issuer": issuer})
