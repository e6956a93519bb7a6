#include "db/store.hpp"
#include "db/time.hpp"
#include "server/access/accounts.hpp"
#include "server/api/http/session_cookie.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/shapes.hpp"

namespace headstock::api {

namespace {

using boost::asio::awaitable;

json session_json(const Principal& who) {
  json raised = json::object();
  if (who.rights)
    for (const auto& [machine, role] : who.rights->raised()) raised[std::to_string(machine)] = access::to_string(role);
  return {{"look_only", who.look_only},
          {"machine_roles", std::move(raised)},
          {"user", who.user},
          {"name", who.name},
          {"role", to_string(who.role)},
          {"language", who.language},
          {"expires", who.expires_ms > 0 ? time_json(who.expires_ms) : json(nullptr)},
          {"must_change_password", who.must_change_password}};
}

/// HttpOnly: no script can read it. SameSite=Strict: no other site can make a browser send it.
std::string cookie(const std::string& token, std::int64_t seconds, bool secure) {
  return std::string(session_cookie) + "=" + token + "; Path=/; HttpOnly; SameSite=Strict; Max-Age=" +
         std::to_string(seconds) + (secure ? "; Secure" : "");
}

}  // namespace

std::vector<Route> session_routes(Services& s) {
  std::vector<Route> routes;
  routes.push_back(
      {.method = Method::post, .pattern = "/session", .role = Role::none, .summary = "Sign in",
       .takes = Takes::json, .request = "SignIn", .response = "SignedIn", .errors = {"wrong_sign_in", "locked_out"},
       .handler = [&s](Call& call) -> awaitable<Reply> {
         const auto session =
             co_await s.accounts.sign_in(call.body_text("user"), call.body_text("password"), call.request.peer);
         Principal who;
         who.user = session.user.user;
         who.name = session.user.name;
         who.language = session.user.language;
         who.role = role_from(access::to_string(session.user.role));
         who.expires_ms = session.expires_ms;
         who.must_change_password = session.user.must_change_password;
         who.rights = session.rights;
         json answer = session_json(who);
         answer["token"] = session.token;
         Reply reply = json_reply(answer);
         const auto seconds = std::max<std::int64_t>(0, (session.expires_ms - db::now_ms()) / 1000);
         reply.headers.emplace_back("Set-Cookie", cookie(session.token, seconds, call.request.secure));
         co_return reply;
       }});
  routes.push_back({.method = Method::get, .pattern = "/session", .role = Role::viewer, .summary = "Who am I",
                    .response = "Session", .handler = [](Call& call) -> awaitable<Reply> {
                      co_return json_reply(session_json(call.who));
                    }});
  routes.push_back(
      {.method = Method::patch, .pattern = "/session", .role = Role::viewer, .summary = "Change the own name and language",
       .takes = Takes::json, .request = "SessionChange", .response = "User", .errors = {"bad_language"},
       .handler = [&s](Call& call) -> awaitable<Reply> {
         access::UserChange change;
         if (call.body.contains("name")) change.name = call.body_text("name");
         if (call.body.contains("language")) change.language = call.body_text("language");
         const auto actor = actor_of(call);
         const auto user = co_await s.store.run([&](db::Database& db) {
           return access::change_user(db, actor, actor.user_id, change, db::now_ms());
         });
         co_return json_reply(to_json(user));
       }});
  routes.push_back({.method = Method::del, .pattern = "/session", .role = Role::viewer, .summary = "Sign out",
                    .status = 204, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto actor = actor_of(call);
                      const auto token = call.who.token;
                      co_await s.store.run(
                          [&](db::Database& db) { access::sign_out(db, actor, token, db::now_ms()); });
                      Reply reply = empty_reply();
                      reply.headers.emplace_back("Set-Cookie", cookie("", 0, call.request.secure));
                      co_return reply;
                    }});
  routes.push_back(
      {.method = Method::post, .pattern = "/session/password", .role = needs(access::Action::change_own_password),
       .summary = "Change the own password; ends the user's other sessions", .takes = Takes::json,
       .request = "PasswordChange", .status = 204, .errors = {"wrong_sign_in", "weak_password", "locked_out"},
       .handler = [&s](Call& call) -> awaitable<Reply> {
         co_await s.accounts.change_password(actor_of(call), call.who.token, call.body_text("old"),
                                             call.body_text("new"));
         co_return empty_reply();
       }});
  return routes;
}

std::vector<Route> user_routes(Services& s) {
  const Need role = needs(access::Action::manage_users);
  const auto wanted_role = [](const Call& call) {
    const auto wanted = access::role_from(call.body_text("role"));
    if (!wanted) throw Refused("bad_role", call.body_text("role"));
    return *wanted;
  };
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/users", .role = role, .summary = "All users",
                    .response = "Users", .handler = [&s](Call&) -> awaitable<Reply> {
                      const auto users =
                          co_await s.store.run([](db::Database& db) { return access::list_users(db); });
                      co_return json_reply(list_json(users));
                    }});
  routes.push_back(
      {.method = Method::post, .pattern = "/users", .role = role, .summary = "Create a user", .takes = Takes::json,
       .request = "NewUser", .response = "User", .status = 201,
       .errors = {"bad_name", "name_taken", "weak_password", "bad_role"},
       .handler = [&s, wanted_role](Call& call) -> awaitable<Reply> {
         access::NewUser user;
         user.user = call.body_text("user");
         user.name = call.body_text("name", user.user);
         user.role = wanted_role(call);
         user.language = call.body_text("language", "en");
         if (call.body.contains("must_change_password"))
           user.must_change_password = call.body.at("must_change_password").get<bool>();
         const auto created = co_await s.accounts.create(actor_of(call), user, call.body_text("password"));
         co_return json_reply(to_json(created), 201);
       }});
  routes.push_back(
      {.method = Method::patch, .pattern = "/users/{id}", .role = role,
       .summary = "Change a user; a new password must be changed at the next sign-in", .takes = Takes::json,
       .request = "UserChange", .response = "User",
       .errors = {"bad_role", "weak_password", "last_administrator"},
       .handler = [&s, wanted_role](Call& call) -> awaitable<Reply> {
         access::UserChange change;
         std::optional<std::string> password;
         if (call.body.contains("name")) change.name = call.body_text("name");
         if (call.body.contains("language")) change.language = call.body_text("language");
         if (call.body.contains("role")) change.role = wanted_role(call);
         if (call.body.contains("disabled")) change.disabled = call.body.at("disabled").get<bool>();
         if (call.body.contains("password")) password = call.body_text("password");
         const auto user = co_await s.accounts.change(actor_of(call), call.id("id"), change, password);
         co_return json_reply(to_json(user));
       }});
  routes.push_back({.method = Method::del, .pattern = "/users/{id}", .role = role, .summary = "Remove a user",
                    .status = 204, .errors = {"last_administrator"}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto actor = actor_of(call);
                      const auto id = call.id("id");
                      co_await s.store.run(
                          [&](db::Database& db) { access::delete_user(db, actor, id, db::now_ms()); });
                      co_return empty_reply();
                    }});
  return routes;
}

}  // namespace headstock::api
