// Who may do what where. Table-like: a grant, and what follows from it on machine 1, machine 2, and
// shop-wide.
#include "server/access/rights.hpp"

#include <gtest/gtest.h>

#include "db/hash.hpp"
#include "db/machine_store.hpp"
#include "db/refusal.hpp"
#include "server/access/accounts.hpp"
#include "server/access/audit.hpp"
#include "server/access/guessing.hpp"
#include "server/access/password.hpp"
#include "server/access/protection.hpp"
#include "server/access/view_tokens.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::access {
namespace {

std::string refused_with(const std::function<void()>& action) {
  try {
    action();
  } catch (const db::Refusal& refusal) {
    EXPECT_NE(db::refusal_text(refusal.code()), nullptr) << refusal.code();
    return refusal.code();
  }
  return "";
}

class RightsTest : public testing::Test {
 protected:
  RightsTest() {
    for (const char* name : {"Lathe 1", "Lathe 2", "Mill 1"}) {
      db::MachineRow machine;
      machine.name = name;
      machine.profile = "fanuc-0i-t";
      machines.push_back(db::insert_machine(*db, machine));
    }
    keeper = add("boss", Role::administrator);
    user = add("li", Role::operator_);
  }
  std::int64_t add(const std::string& name, Role role) {
    return create_user(*db, Actor{}, {name, name, role, "en", "x", false}, 1).id;
  }
  std::shared_ptr<const Rights> rights() { return rights_of(*db, user, Role::operator_); }
  void grant(std::vector<db::GrantRow> rows) { set_grants(*db, Actor{}, user, rows); }

  test::TemporaryFolder folder;
  std::unique_ptr<db::Database> db = test::open_shop(folder / "s.db");
  std::vector<std::int64_t> machines;
  std::int64_t user = 0, keeper = 0;
};

TEST_F(RightsTest, WithoutGrantsTheRoleCounts) {
  for (const auto machine : {kNoMachine, machines[0]}) {
    EXPECT_TRUE(rights()->may(Action::command_machine, machine));
    EXPECT_FALSE(rights()->may(Action::edit_offsets, machine));
  }
}

TEST_F(RightsTest, ARoleOnOneMachineIsNoRoleElsewhere) {
  grant({{0, user, machines[0], 0, "setter", "", true}});
  EXPECT_TRUE(rights()->may(Action::edit_offsets, machines[0]));
  EXPECT_FALSE(rights()->may(Action::edit_offsets, machines[1]));
  EXPECT_FALSE(rights()->may(Action::edit_offsets, kNoMachine));
  EXPECT_TRUE(rights()->may(Action::edit_offsets, kAnyMachine));
  EXPECT_FALSE(rights()->may(Action::manage_users, machines[0]));
  EXPECT_EQ(rights()->raised(), (std::map<std::int64_t, Role>{{machines[0], Role::setter}}));
}

TEST_F(RightsTest, AGroupIsItsMachinesAsTheyAreNow) {
  const auto group = put_group(*db, Actor{}, {0, "Lathes", {machines[0]}});
  grant({{0, user, 0, group, "programmer", "", true}});
  EXPECT_TRUE(rights()->may(Action::send_program, machines[0]));
  EXPECT_FALSE(rights()->may(Action::send_program, machines[1]));
  put_group(*db, Actor{}, {group, "Lathes", {machines[1]}});
  EXPECT_FALSE(rights()->may(Action::send_program, machines[0]));
  EXPECT_TRUE(rights()->may(Action::send_program, machines[1]));
  remove_group(*db, Actor{}, group);
  EXPECT_FALSE(rights()->may(Action::send_program, machines[1]));
}

TEST_F(RightsTest, AnActionMayBeAllowedOrForbiddenAlone) {
  grant({{0, user, 0, 0, "", "release_program", true},
         {0, user, machines[1], 0, "", "command_machine", false}});
  EXPECT_TRUE(rights()->may(Action::release_program, kNoMachine));
  EXPECT_FALSE(rights()->may(Action::upload_program, kNoMachine));
  EXPECT_TRUE(rights()->may(Action::command_machine, machines[0]));
  EXPECT_FALSE(rights()->may(Action::command_machine, machines[1]));
  EXPECT_TRUE(rights()->may(Action::command_machine, kAnyMachine));
}

TEST_F(RightsTest, AProhibitionBeatsEveryPermission) {
  grant({{0, user, 0, 0, "administrator", "", true},
         {0, user, machines[0], 0, "", "edit_offsets", true},
         {0, user, 0, 0, "", "edit_offsets", false}});
  EXPECT_FALSE(rights()->may(Action::edit_offsets, machines[0]));
  EXPECT_FALSE(rights()->may(Action::edit_offsets, kAnyMachine));
  EXPECT_TRUE(rights()->may(Action::manage_users, kNoMachine));
}

TEST_F(RightsTest, ServicesAskForEveryMachineOfTheCall) {
  grant({{0, user, machines[0], 0, "setter", "", true}});
  Actor actor{user, "li", Role::operator_, "", rights(), {machines[0]}};
  EXPECT_NO_THROW(demand(actor, Action::edit_offsets));
  actor.machines = {machines[0], machines[1]};
  EXPECT_EQ(refused_with([&] { demand(actor, Action::edit_offsets); }), "forbidden");
  actor.machines.clear();
  EXPECT_EQ(refused_with([&] { demand(actor, Action::edit_offsets); }), "forbidden");
}

TEST_F(RightsTest, NonsenseIsRefusedAndNothingKept) {
  grant({{0, user, machines[0], 0, "setter", "", true}});
  for (const db::GrantRow& bad : {db::GrantRow{0, user, machines[0], 7, "setter", "", true},
                                  {0, user, 999, 0, "setter", "", true},
                                  {0, user, 0, 0, "king", "", true},
                                  {0, user, 0, 0, "", "fly", true},
                                  {0, user, 0, 0, "", "", true},
                                  {0, user, 0, 0, "setter", "edit_offsets", true},
                                  {0, user, 0, 0, "setter", "", false}})
    EXPECT_NE(refused_with([&] { grant({bad}); }), "");
  EXPECT_TRUE(rights()->may(Action::edit_offsets, machines[0]));
}

TEST_F(RightsTest, SomebodyMustBeLeftWhoManagesUsers) {
  user = keeper;
  EXPECT_EQ(refused_with([&] { grant({{0, user, 0, 0, "", "manage_users", false}}); }), "last_administrator");
  add("second", Role::administrator);
  EXPECT_NO_THROW(grant({{0, user, 0, 0, "", "manage_users", false}}));
}

TEST_F(RightsTest, OnlyWhoManagesUsersGrants) {
  const Actor li{user, "li", Role::operator_, "", rights(), {}};
  EXPECT_EQ(refused_with([&] { set_grants(*db, li, user, {}); }), "forbidden");
  EXPECT_EQ(refused_with([&] { put_group(*db, li, {0, "x", {}}); }), "forbidden");
}

TEST_F(RightsTest, AScreensSecretIsShownOnceExpiresAndIsRevoked) {
  const auto made = create_view_token(*db, Actor{}, "Hall 1", 5'000, 1'000);
  ASSERT_EQ(made.token.size(), 64u);
  EXPECT_TRUE(find_view_token(*db, made.token, 4'999));
  EXPECT_FALSE(find_view_token(*db, made.token, 5'000));
  EXPECT_FALSE(find_view_token(*db, std::string(64, 'a'), 1'000));
  EXPECT_FALSE(db->integer("SELECT 1 FROM view_tokens WHERE token_sha256 = ?", {made.token}))
      << "only its hash is kept";
  revoke_view_token(*db, Actor{}, made.id, 2'000);
  EXPECT_FALSE(find_view_token(*db, made.token, 2'001));
  EXPECT_EQ(refused_with([&] { revoke_view_token(*db, Actor{}, made.id, 2'000); }), "not_found");
}

TEST_F(RightsTest, SessionsEndUnusedWhenTheShopSaysSo) {
  set_policy(*db, Actor{}, {12, 10, 8});
  const auto row = db::user(*db, user);
  const auto session = start_session(*db, *row, "", "test", 0);
  EXPECT_TRUE(find_session(*db, session.token, 9 * 60'000));
  EXPECT_TRUE(find_session(*db, session.token, 18 * 60'000)) << "used at minute 9";
  EXPECT_FALSE(find_session(*db, session.token, 28 * 60'000));
  EXPECT_EQ(refused_with([&] { set_policy(*db, Actor{}, {0, 0, 8}); }), "bad_value");
  EXPECT_EQ(refused_with([&] { set_policy(*db, Actor{}, {1, 1, 8}); }), "bad_value");
}

TEST_F(RightsTest, AnAddressThatGuessesIsLockedWhateverTheUser) {
  const SignInPolicy policy;
  for (int i = 0; i < policy.address_failures_before_lock - 1; ++i)
    count_address_failure(*db, "10.0.0.9", policy, 1'000);
  EXPECT_EQ(refused_with([&] { demand_patient_address(*db, "10.0.0.9", 1'000); }), "");
  count_address_failure(*db, "10.0.0.9", policy, 1'000);
  EXPECT_EQ(refused_with([&] { demand_patient_address(*db, "10.0.0.9", 1'000 + policy.lock_ms - 1); }),
            "locked_out");
  EXPECT_EQ(refused_with([&] { demand_patient_address(*db, "10.0.0.9", 1'000 + policy.lock_ms); }), "");
  EXPECT_EQ(refused_with([&] { demand_patient_address(*db, "10.0.0.8", 1'000); }), "");
  // A quarter of an hour without a failure, and it is forgotten.
  count_address_failure(*db, "10.0.0.9", policy, 2'000'000);
  EXPECT_EQ(db::failing_address(*db, "10.0.0.9")->failures, 1);
}

TEST(Guessing, AClockThatIsSetBackLocksNobodyForYears) {
  EXPECT_TRUE(is_locked(1'000 + 60'000, 1'000));
  EXPECT_FALSE(is_locked(365ll * 86'400'000, 1'000));
}

TEST(Passwords, WhatIsTooEasy) {
  const auto of = [](const char* password, const char* user, std::int64_t least) {
    return refused_with([&] { demand_good_password(password, user, least); });
  };
  EXPECT_EQ(of("a fine one", "li", 8), "");
  EXPECT_EQ(of("a fine one", "li", 12), "weak_password");
  EXPECT_EQ(of("Machinist1", "machinist", 8), "weak_password");
  EXPECT_EQ(of("Password1", "li", 8), "common_password");
  EXPECT_EQ(of("aaaaaaaaaaaa", "li", 8), "common_password");
  EXPECT_EQ(of("车床铣床磨床钻床", "li", 8), "");
}

TEST(Protection, EveryProfileHasItsLevelsHighestFirst) {
  for (const char* profile :
       {"fanuc-0i-t", "fanuc-0i-m", "gsk-2000tc", "gsk-218t", "k2000tc", "lathe-200t"}) {
    const auto levels = protection_levels(profile);
    ASSERT_FALSE(levels.empty()) << profile;
    for (std::size_t i = 1; i < levels.size(); ++i) EXPECT_LE(levels[i].role, levels[i - 1].role) << profile;
    EXPECT_EQ(levels.back().role, Role::operator_) << profile;
  }
  // 2000TC L7602: parameters from level 3 on, level 4 not.
  EXPECT_EQ(protection_levels("gsk-2000tc")[1].role, required(Action::edit_machine));
  EXPECT_TRUE(protection_levels("other").empty());
}

TEST(AuditVerdict, AnEndThatWasCutOffIsFoundByWhatWasSeen) {
  test::TemporaryFolder folder;
  const auto db = db::open_sqlite(folder / "s.db");
  db::migrate(*db);
  for (int i = 0; i < 5; ++i) record(*db, Actor{}, "test.row", "x:" + std::to_string(i));
  const auto seen = verify_audit(*db, {});
  EXPECT_EQ(seen.broken, 0);
  EXPECT_EQ(seen.head.id, 5);
  // As somebody with the file in hand could.
  db->script("DROP TRIGGER audit_kept_delete; DROP TRIGGER audit_kept_update");
  db->execute("DELETE FROM audit WHERE id = 5");
  EXPECT_EQ(verify_audit(*db, {}).broken, 0) << "the rest is whole";
  EXPECT_EQ(verify_audit(*db, seen.head).what, "cut");
  record(*db, Actor{}, "test.other", "x:5");
  EXPECT_EQ(verify_audit(*db, seen.head).what, "changed") << "a new row in its place";
  db->execute("UPDATE audit SET detail = '{}', user = 'nobody' WHERE id = 2");
  EXPECT_EQ(verify_audit(*db, {}).broken, 2);
  db->execute("DELETE FROM audit WHERE id = 2");
  EXPECT_EQ(verify_audit(*db, {}).what, "missing");
}

}  // namespace
}  // namespace headstock::access
