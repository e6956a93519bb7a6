// Who may join: tokens, certificates, identities.
#include <gtest/gtest.h>

#include <ctime>

#include "link/identity.hpp"
#include "tests/unit/link/shop.hpp"

namespace headstock {
namespace {

using namespace testing_support;
using namespace std::chrono_literals;

TEST(Enrolment, TokenGivesACertificateThatIsKeptOverRestarts) {
  Shop shop;
  Agent agent(shop.folder.path() / "agent");
  auto options = agent.options(shop.gateway->port());
  options.enrolment_token = shop.token_for(7);
  agent.connect(shop.io, options);
  ASSERT_TRUE(shop.until([&] { return shop.gateway->is_connected(7); }));
  EXPECT_TRUE(shop.until([&] { return agent.link->status().connected; }));
  EXPECT_EQ(agent.link->status().machine, 7);
  EXPECT_EQ(agent.machine.ups, 1);
  EXPECT_EQ(shop.fleet.hello_of[7]["profile"], "fanuc-0i-t");
  EXPECT_TRUE(shop.fleet.tokens.empty()) << "a token is used once";

  agent.link.reset();
  EXPECT_TRUE(shop.until([&] { return !shop.gateway->is_connected(7); }));
  agent.connect(shop.io, agent.options(shop.gateway->port()));  // without a token
  EXPECT_TRUE(shop.until([&] { return shop.gateway->is_connected(7); }));
}

TEST(Enrolment, WrongUsedOrForeignTokensAreRefused) {
  Shop shop;
  Agent agent(shop.folder.path() / "agent");
  auto options = agent.options(shop.gateway->port());

  options.enrolment_token = wire::format_token({wire::make_secret(), shop.gateway->ca_fingerprint()});
  agent.connect(shop.io, options);
  ASSERT_TRUE(shop.until([&] { return agent.link->status().detail.find("bad_token") != std::string::npos; }))
      << agent.link->status().detail;

  // Of another server: the agent sends nothing, so the secret stays secret.
  const std::string secret = wire::make_secret();
  shop.fleet.tokens[secret] = 8;
  options.enrolment_token = wire::format_token({secret, std::string(64, 'a')});
  agent.connect(shop.io, options);
  ASSERT_TRUE(shop.until([&] {
    return agent.link->status().detail.find("not the one that made this token") != std::string::npos;
  })) << agent.link->status().detail;
  EXPECT_TRUE(shop.fleet.tokens.contains(secret));

  EXPECT_THROW((options.enrolment_token = "HS1-nonsense", agent.connect(shop.io, options)),
               std::runtime_error);
}

TEST(Enrolment, WithoutATokenItSaysSo) {
  Shop shop;
  Agent agent(shop.folder.path() / "agent");
  agent.connect(shop.io, agent.options(shop.gateway->port()));
  EXPECT_TRUE(
      shop.until([&] { return agent.link->status().detail.find("not enrolled") != std::string::npos; }));
}

TEST(Enrolment, EnrollingAgainRevokesTheOldCertificate) {
  Shop shop;
  Agent first(shop.folder.path() / "first"), second(shop.folder.path() / "second");
  auto options = first.options(shop.gateway->port());
  options.enrolment_token = shop.token_for(7);
  first.connect(shop.io, options);
  ASSERT_TRUE(shop.until([&] { return shop.gateway->is_connected(7); }));
  options = second.options(shop.gateway->port());
  options.enrolment_token = shop.token_for(7);
  second.connect(shop.io, options);
  ASSERT_TRUE(shop.until([&] { return second.link->status().connected; })) << second.link->status().detail;
  EXPECT_TRUE(shop.until([&] { return first.link->status().detail.find("revoked") != std::string::npos; }))
      << first.link->status().detail;
  EXPECT_EQ(first.machine.losts, 1);
}

/// Puts credentials made by hand into the agent's folder.
void give(const Agent& agent, const wire::Authority& authority, std::int64_t machine, wire::Validity validity,
          FakeFleet* fleet) {
  const auto made = wire::make_key_and_request("agent");
  const auto issued = authority.sign(made.request_pem, machine, validity);
  link::Identity(agent.pki).store({made.key_pem, issued.pem, authority.ca_pem()});
  if (fleet) fleet->certificates[machine] = issued.serial_hex;
}

TEST(Enrolment, ExpiredCertificateIsRefusedWithItsReason) {
  Shop shop;
  Agent agent(shop.folder.path() / "agent");
  const wire::Authority authority(shop.gateway_options().pki_folder, {});
  const auto now = static_cast<std::int64_t>(std::time(nullptr));
  give(agent, authority, 7, {now - 1000, now - 10}, &shop.fleet);
  agent.connect(shop.io, agent.options(shop.gateway->port()));
  EXPECT_TRUE(shop.until([&] { return agent.link->status().detail.find("expired") != std::string::npos; }))
      << agent.link->status().detail;
  EXPECT_EQ(shop.fleet.connects[7], 0);
}

TEST(Enrolment, ForeignCertificateIsRefusedByBothSides) {
  Shop shop;
  const TemporaryFolder elsewhere;
  const wire::Authority foreign(elsewhere.path(), {});
  const wire::Authority own(shop.gateway_options().pki_folder, {});
  const auto now = static_cast<std::int64_t>(std::time(nullptr));

  // The agent trusts only the other shop: it refuses our server.
  Agent stranger(shop.folder.path() / "stranger");
  give(stranger, foreign, 7, {now - 10, now + 1000}, &shop.fleet);
  stranger.connect(shop.io, stranger.options(shop.gateway->port()));
  EXPECT_TRUE(shop.until([&] {
    return stranger.link->status().detail.find("certificate not accepted") != std::string::npos;
  })) << stranger.link->status().detail;

  // It knows our CA but shows a certificate of the other shop: our server refuses it.
  Agent forger(shop.folder.path() / "forger");
  const auto made = wire::make_key_and_request("agent");
  const auto issued = foreign.sign(made.request_pem, 7);
  link::Identity(forger.pki).store({made.key_pem, issued.pem, own.ca_pem()});
  shop.fleet.certificates[7] = issued.serial_hex;
  forger.connect(shop.io, forger.options(shop.gateway->port()));
  EXPECT_TRUE(shop.until([&] {
    return forger.link->status().detail.find("unknown ca") != std::string::npos;
  })) << forger.link->status().detail;
  EXPECT_EQ(shop.fleet.connects[7], 0);
}

TEST(Enrolment, TwoAgentsWithOneIdentityTheOlderStays) {
  Shop shop;
  Agent first(shop.folder.path() / "first"), second(shop.folder.path() / "second");
  auto options = first.options(shop.gateway->port());
  options.enrolment_token = shop.token_for(7);
  first.connect(shop.io, options);
  ASSERT_TRUE(shop.until([&] { return first.link->status().connected; }));
  std::filesystem::create_directories(second.pki);
  std::filesystem::copy_file(first.pki / "agent.pem", second.pki / "agent.pem");
  second.connect(shop.io, second.options(shop.gateway->port()));
  ASSERT_TRUE(shop.until([&] {
    return second.link->status().detail.find("identity_in_use") != std::string::npos;
  })) << second.link->status().detail;
  EXPECT_TRUE(first.link->status().connected);
  EXPECT_EQ(shop.fleet.connects[7], 1);
  EXPECT_EQ(first.machine.losts, 0);
}

TEST(Enrolment, DeadOlderConnectionGivesWay) {
  Shop shop;
  CuttingProxy proxy(shop.io, shop.gateway->port());
  Agent agent(shop.folder.path() / "agent");
  auto options = agent.options(proxy.port());
  options.enrolment_token = shop.token_for(7);
  agent.connect(shop.io, options);
  ASSERT_TRUE(shop.until([&] { return agent.link->status().connected; }));
  proxy.stalled = true;  // the line is dead, but no one was told
  agent.link.reset();
  agent.connect(shop.io, agent.options(shop.gateway->port()));
  EXPECT_TRUE(shop.until([&] { return agent.link->status().connected; })) << agent.link->status().detail;
  EXPECT_EQ(shop.fleet.connects[7], 2);
}

TEST(Enrolment, CertificateIsRenewedInItsLastThird) {
  Shop shop;
  Agent agent(shop.folder.path() / "agent");
  const wire::Authority authority(shop.gateway_options().pki_folder, {});
  const auto now = static_cast<std::int64_t>(std::time(nullptr));
  give(agent, authority, 7, {now - 800, now + 200}, &shop.fleet);
  const std::string old_serial = shop.fleet.certificates[7];
  agent.connect(shop.io, agent.options(shop.gateway->port()));
  ASSERT_TRUE(shop.until([&] { return shop.fleet.certificates[7] != old_serial; }));
  ASSERT_TRUE(shop.until([&] { return !std::filesystem::exists(agent.pki / "agent.next.pem"); }));
  const link::Identity identity(agent.pki);
  const auto info = wire::read_certificate(identity.credentials().certificate_pem);
  EXPECT_EQ(info.serial_hex, shop.fleet.certificates[7]);
  EXPECT_GT(info.not_after_s, now + 300 * 86'400);
  agent.link.reset();
  agent.connect(shop.io, agent.options(shop.gateway->port()));
  EXPECT_TRUE(shop.until([&] { return agent.link->status().connected; })) << agent.link->status().detail;
}

TEST(Enrolment, RenewalCutHalfWayFallsBackToTheOldCertificate) {
  Shop shop;
  Agent agent(shop.folder.path() / "agent");
  const wire::Authority authority(shop.gateway_options().pki_folder, {});
  const auto now = static_cast<std::int64_t>(std::time(nullptr));
  give(agent, authority, 7, {now - 10, now + 10'000}, &shop.fleet);
  // Stored at the agent, but the server was killed before it heard of it.
  const auto made = wire::make_key_and_request("agent");
  link::Identity(agent.pki).store_renewed(
      {made.key_pem, authority.sign(made.request_pem, 7).pem, authority.ca_pem()});
  agent.connect(shop.io, agent.options(shop.gateway->port()));
  EXPECT_TRUE(shop.until([&] { return agent.link->status().connected; })) << agent.link->status().detail;
  EXPECT_FALSE(std::filesystem::exists(agent.pki / "agent.next.pem"));
}

}  // namespace
}  // namespace headstock
