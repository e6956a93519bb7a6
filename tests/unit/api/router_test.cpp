#include <gtest/gtest.h>

#include "server/api/http/router.hpp"

namespace headstock::api {
namespace {

Route row(Method method, const char* pattern, Role role = Role::viewer) {
  Route route;
  route.method = method;
  route.pattern = pattern;
  route.role = role;
  return route;
}

Router sample() {
  Router router;
  router.add({row(Method::get, "/machines"), row(Method::post, "/machines", Role::administrator),
              row(Method::get, "/machines/{id}"), row(Method::get, "/programs/{id}/revisions/{n}/content")});
  return router;
}

TEST(Router, FindsTheRowAndItsParameters) {
  const auto router = sample();
  const auto match = router.match(Method::get, "/programs/7/revisions/2/content");
  ASSERT_NE(match.route, nullptr);
  EXPECT_EQ(match.route->pattern, "/programs/{id}/revisions/{n}/content");
  EXPECT_EQ(match.parameters.at("id"), "7");
  EXPECT_EQ(match.parameters.at("n"), "2");
}

TEST(Router, SaysWhichMethodsAPathHas) {
  const auto router = sample();
  const auto match = router.match(Method::del, "/machines");
  EXPECT_EQ(match.route, nullptr);
  EXPECT_EQ(match.allow, "GET, POST");
}

TEST(Router, UnknownPathHasNoMethods) {
  const auto match = sample().match(Method::get, "/machine");
  EXPECT_EQ(match.route, nullptr);
  EXPECT_EQ(match.allow, "");
}

TEST(Router, TheSameRowTwiceIsAMistake) {
  auto router = sample();
  EXPECT_THROW(router.add({row(Method::get, "/machines/{id}")}), std::logic_error);
}

TEST(Router, ParametersMustBeNumbersWhereANumberIsMeant) {
  Call call;
  call.request.parameters = {{"id", "7"}, {"bad", "7x"}, {"minus", "-1"}, {"huge", "99999999999999999999"}};
  EXPECT_EQ(call.id("id"), 7);
  EXPECT_THROW(call.id("bad"), Refused);
  EXPECT_THROW(call.id("minus"), Refused);
  EXPECT_THROW(call.id("huge"), Refused);
  EXPECT_THROW(call.id("absent"), Refused);
}

// Every role against every least role: exactly those at or above may.
TEST(Admission, RolesIncludeTheOnesBefore) {
  Headers headers;
  for (int has = 0; has <= 5; ++has)
    for (int needs = 0; needs <= 5; ++needs) {
      Principal who;
      who.role = static_cast<Role>(has);
      const auto code = admission(row(Method::get, "/x", static_cast<Role>(needs)), who, false, headers);
      EXPECT_EQ(code.empty(), has >= needs) << has << " against " << needs;
      if (has < needs) {
        EXPECT_EQ(code, has == 0 ? "unauthenticated" : "forbidden");
      }
    }
}

TEST(Admission, ACookieAloneChangesNothing) {
  Principal who;
  who.role = Role::administrator;
  Headers headers;
  const auto change = row(Method::post, "/x");
  EXPECT_EQ(admission(change, who, true, headers), "cross_site");
  EXPECT_EQ(admission(change, who, false, headers), "");
  EXPECT_EQ(admission(row(Method::get, "/x"), who, true, headers), "");
  headers.x_headstock = "1";
  EXPECT_EQ(admission(change, who, true, headers), "");
}

TEST(Roles, NamesGoBothWays) {
  for (int i = 1; i <= 5; ++i) EXPECT_EQ(role_from(to_string(static_cast<Role>(i))), static_cast<Role>(i));
  EXPECT_EQ(role_from("root"), Role::none);
  EXPECT_EQ(role_from(""), Role::none);
}

TEST(Errors, EveryCodeHasBothLanguagesAndAStatus) {
  for (const auto& text : all_error_texts()) {
    EXPECT_FALSE(text.en.empty()) << text.code;
    EXPECT_FALSE(text.zh.empty()) << text.code;
    EXPECT_GE(text.status, 400u) << text.code;
  }
  EXPECT_EQ(error_text("no such code").code, "internal");
  EXPECT_EQ(error_text("forbidden").status, 403u);
  EXPECT_EQ(error_text("unauthenticated").status, 401u);
  EXPECT_EQ(error_text("not_found").status, 404u);
}

}  // namespace
}  // namespace headstock::api
