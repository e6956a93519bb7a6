#include "protocol/wire/certificates.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <ctime>
#include <fstream>

#include "tests/unit/temporary_folder.hpp"

namespace headstock::wire {
namespace {

using testing_support::TemporaryFolder;

TEST(Authority, IsMadeOnceAndKept) {
  const TemporaryFolder folder;
  std::string fingerprint, server;
  {
    const Authority authority(folder.path(), {});
    fingerprint = authority.ca_fingerprint();
    server = authority.server_pem();
    EXPECT_EQ(fingerprint.size(), 64u);
    EXPECT_EQ(fingerprint, wire::fingerprint(authority.ca_pem()));
  }
  const Authority again(folder.path(), {});
  EXPECT_EQ(again.ca_fingerprint(), fingerprint);
  EXPECT_EQ(again.server_pem(), server);
  for (const char* key : {"ca.key", "server.key"}) {
    struct stat status {};
    ASSERT_EQ(::stat((folder.path() / key).c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600u) << key;
  }
}

TEST(Authority, NewNameMakesANewServerCertificateOfTheSameAuthority) {
  const TemporaryFolder folder;
  const Authority first(folder.path(), {});
  const Authority second(folder.path(), {"cnc-server", "192.0.2.7"});
  EXPECT_NE(first.server_pem(), second.server_pem());
  EXPECT_EQ(first.ca_fingerprint(), second.ca_fingerprint());
  EXPECT_THROW(Authority(folder.path(), {"bad,DNS:evil"}), CertificateError);
}

TEST(Authority, LostKeyIsRefusedNotReplaced) {
  const TemporaryFolder folder;
  { const Authority authority(folder.path(), {}); }
  std::filesystem::rename(folder.path() / "ca.key", folder.path() / "elsewhere");
  EXPECT_THROW(Authority(folder.path(), {}), CertificateError);
  std::ofstream(folder.path() / "ca.key") << "rubbish";
  EXPECT_THROW(Authority(folder.path(), {}), CertificateError);
  std::filesystem::rename(folder.path() / "elsewhere", folder.path() / "ca.key");
  EXPECT_NO_THROW(Authority(folder.path(), {}));
}

TEST(Authority, DamagedServerCertificateIsMadeAgain) {
  const TemporaryFolder folder;
  { const Authority authority(folder.path(), {}); }
  std::ofstream(folder.path() / "server.pem") << "rubbish";
  const Authority again(folder.path(), {});
  EXPECT_EQ(read_certificate(again.server_pem()).common_name, "headstock-server");
}

TEST(Authority, SignsForOneMachineForAYear) {
  const TemporaryFolder folder;
  const Authority authority(folder.path(), {});
  const auto made = make_key_and_request("whatever it claims");
  const auto issued = authority.sign(made.request_pem, 12);
  const auto info = read_certificate(issued.pem);
  EXPECT_EQ(info.common_name, "agent-12");
  EXPECT_EQ(machine_of_name(info.common_name), 12);
  EXPECT_EQ(info.serial_hex, issued.serial_hex);
  const auto now = static_cast<std::int64_t>(std::time(nullptr));
  EXPECT_NEAR(static_cast<double>(info.not_after_s - now), 365.0 * 86'400, 60);
  EXPECT_FALSE(due_for_renewal(info, now));
  EXPECT_TRUE(due_for_renewal(info, now + 250 * 86'400));
  EXPECT_NE(authority.sign(made.request_pem, 12).serial_hex, issued.serial_hex);
}

TEST(Authority, RefusesWhatIsNoRequest) {
  const TemporaryFolder folder;
  const Authority authority(folder.path(), {});
  EXPECT_THROW(authority.sign("", 1), CertificateError);
  EXPECT_THROW(authority.sign(authority.ca_pem(), 1), CertificateError);
  std::string tampered = make_key_and_request("a").request_pem;
  // Inside the base64 of the signature.
  char& c = tampered[tampered.size() - 60];
  c = c == 'A' ? 'B' : 'A';
  EXPECT_THROW(authority.sign(tampered, 1), CertificateError);
}

TEST(Names, OnlyAgentsHaveMachines) {
  EXPECT_EQ(machine_of_name("agent-7"), 7);
  for (const char* name :
       {"", "agent-", "agent-0", "agent--1", "agent-7x", "server-7", "agent-99999999999999999999"})
    EXPECT_EQ(machine_of_name(name), 0) << name;
}

TEST(Token, ThereAndBack) {
  const EnrolmentToken token{make_secret(), std::string(64, 'f')};
  const auto back = parse_token(" " + format_token(token) + "\n");
  ASSERT_TRUE(back);
  EXPECT_EQ(back->secret, token.secret);
  EXPECT_EQ(back->ca_fingerprint, token.ca_fingerprint);
  EXPECT_NE(make_secret(), token.secret);
  for (const std::string& bad :
       {std::string(), std::string("HS1-"), std::string("HS2-") + token.secret + "-" + token.ca_fingerprint,
        "HS1-short-" + token.ca_fingerprint, "HS1-" + token.secret + "-" + std::string(63, 'f'),
        "HS1-" + token.secret + "-" + std::string(64, 'g')})
    EXPECT_FALSE(parse_token(bad)) << bad;
}

}  // namespace
}  // namespace headstock::wire
