"""Bad part programs: each is stored exactly as it came, each check says what and where, nothing is lost."""
import hashlib

from shop import ApiError, ShopTest

LONG_LINE = b"O5\nG00 X" + b"1" * (10 << 20) + b"\nM30\n"
# name → (bytes, is the check clean?, line of the first finding or None)
CASES = {
    "syntax-error": (b"O1\nG00 X10. Z5.\nG01 X=5 F0.2\nM30\n", False, 3),
    "unknown-g": (b"O2\nG00 X10.\nG777 X5.\nM30\n", False, 3),
    "ten-megabytes-on-one-line": (LONG_LINE, False, 2),
    "nul-bytes": (b"O6\nG00 X10.\x00\x00\nG00 Z5.\nM30\n", None, None),
    "utf8-comment": ("O7\n(粗车外圆)\nG00 X10.\nM30\n".encode(), True, None),
    "gbk-comment": ("O8\n(粗车外圆)\nG00 X10.\nM30\n".encode("gbk"), True, None),
    "crlf": (b"O9\r\nG00 X10.\r\nM30\r\n", True, None),
    "cr-only": (b"O10\rG00 X10.\rM30\r", True, None),
    "no-percent": (b"O11\nG00 X10.\nM30\n", True, None),
}


class BadPrograms(ShopTest):
    def test_each_is_kept_as_it_is_and_explained(self):
        self.shop.start_server()
        lathe = self.shop.admin.post("/machines", {"name": "Lathe 1", "profile": "fanuc-0i-t"})
        for name, (content, clean, line) in CASES.items():
            with self.subTest(name):
                made = self.shop.upload(name + ".nc", content)
                program, revision = made["program"]["id"], made["revision"]["number"]
                self.assertEqual(made["revision"]["sha256"], hashlib.sha256(content).hexdigest())
                self.assertEqual(self.shop.admin.get(f"/programs/{program}/revisions/{revision}/content"), content)
                again = self.shop.upload(name + ".nc", content)
                self.assertEqual(again["revision"]["number"], revision, "the same content is the same revision")
                check = self.shop.admin.call("POST", f"/programs/{program}/revisions/{revision}/check",
                                             {"machine": lathe["id"]})
                if clean is not None:
                    self.assertEqual(check["ok"], clean, check)
                if not check["ok"]:
                    first = check["findings"][0]
                    self.assertTrue(first["code"] and first["text"]["en"] and first["text"]["zh"], first)
                    if line:
                        self.assertEqual(first["line"], line, first)
        self.assertTrue(self.shop.server.running())

    def test_an_empty_file_is_refused_in_words(self):
        self.shop.start_server()
        with self.assertRaises(ApiError) as refused:
            self.shop.upload("empty.nc", b"")
        self.assertEqual((refused.exception.status, refused.exception.code), (400, "empty_program"))
        self.assertEqual(self.shop.admin.get("/programs")["items"], [])

    def test_comments_are_shown_in_their_encoding(self):
        self.shop.start_server()
        for name in ("utf8-comment", "gbk-comment"):
            made = self.shop.upload(name + ".nc", CASES[name][0])
            text = self.shop.admin.get(f"/programs/{made['program']['id']}/revisions/1/content", from_line=1, lines=10)
            self.assertIn("粗车外圆", str(text), f"{name}: {text}")
