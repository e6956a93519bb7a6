#include "server/integrations/deliver.hpp"

#include <gtest/gtest.h>

namespace headstock::integrations {
namespace {

TEST(Mail, IsAWellFormedMessage) {
  const auto text = mail_text({"smtp://x", "", "", "Shop <s@example.test>", false},
                              {"a@example.test", "Lathe 1: OT0500 超程", "one\r\n二\r\n"}, 0, "id1");
  EXPECT_NE(text.find("From: Shop <s@example.test>\r\n"), std::string::npos);
  EXPECT_NE(text.find("Date: Thu, 01 Jan 1970 00:00:00 +0000\r\n"), std::string::npos);
  EXPECT_NE(text.find("Subject: =?UTF-8?B?"), std::string::npos);
  EXPECT_NE(text.find("\r\n\r\nb25lDQrkuowNCg=="), std::string::npos) << text;
  for (std::size_t at = 0, end = 0; (end = text.find("\r\n", at)) != std::string::npos; at = end + 2) EXPECT_LE(end - at, 78u);
}

TEST(Mail, DataCannotAddHeaders) {
  const auto text = mail_text({"", "", "", "s@example.test", false}, {"a@b.c\r\nBcc: evil@x.y", "x\r\nBcc: evil@x.y", ""}, 0, "id");
  EXPECT_EQ(text.find("\r\nBcc:"), std::string::npos);
}

TEST(Mail, SaysInBothLanguagesWhatHappened) {
  const auto mail = mail_of(R"({"step":"first","machine":{"name":"Lathe 1"},"code":"OT0500","text":{"en":"over travel","zh":"超程"},"since":"2026"})",
                            "a@b.c", "https://shop/#/alarms");
  EXPECT_EQ(mail.subject, "[!] Lathe 1: OT0500 超程 / over travel");
  EXPECT_NE(mail.text.find("https://shop/#/alarms"), std::string::npos);
  EXPECT_EQ(mail_of(R"({"step":"escalation"})", "", "").subject.substr(0, 4), "[!!]");
}

TEST(Delivery, NothingThereIsAProblemAndNoCrash) {
  EXPECT_NE(send_mail({}, {}), "");
  EXPECT_NE(send_mail({"smtp://127.0.0.1:1", "", "", "s@example.test", false}, {"a@b.c", "s", "t"}), "");
  EXPECT_NE(call_webhook("http://127.0.0.1:1/", "{}", ""), "");
  EXPECT_NE(call_webhook("file:///etc/passwd", "{}", ""), "");
}

}  // namespace
}  // namespace headstock::integrations
