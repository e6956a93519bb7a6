// Signing in through an OpenID Connect provider.
#include "db/access_store.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "server/api/http/session_cookie.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/shapes.hpp"
#include "server/integrations/notifier.hpp"
#include "server/integrations/sign_in_provider.hpp"

namespace headstock::api {

namespace {

using access::Action;
using boost::asio::awaitable;

constexpr const char* kStateCookie = "headstock_provider";
constexpr const char* kReturn = "/session/provider/return";

json provider_json(const integrations::ProviderSettings& settings) {
  return {{"issuer", settings.issuer}, {"client_id", settings.client_id}, {"client_secret_set", !settings.client_secret.empty()},
          {"label", settings.label},   {"create", settings.create},       {"role", access::to_string(settings.role)}};
}

/// As people reach this server: the address that was set, otherwise the one of this request.
awaitable<std::string> return_address(Services& s, const Call& call) {
  const auto settings = co_await s.store.run([](db::Database& db) { return integrations::message_settings(db); });
  std::string base = settings.link;
  if (base.empty()) base = std::string(call.request.secure ? "https://" : "http://") + call.request.headers.host;
  while (base.ends_with('/')) base.pop_back();
  co_return base + std::string(api_prefix) + kReturn;
}

std::string state_cookie(const std::string& value, int seconds, bool secure) {
  return std::string(kStateCookie) + "=" + value + "; Path=/api/v1/session; HttpOnly; SameSite=Lax; Max-Age=" +
         std::to_string(seconds) + (secure ? "; Secure" : "");
}

std::string cookie_in(const std::string& header, const std::string& name) {
  const auto at = header.find(name + "=");
  if (at == std::string::npos) return "";
  const auto from = at + name.size() + 1;
  return header.substr(from, std::min(header.find(';', from), header.size()) - from);
}

awaitable<Reply> finish_sign_in(Services& s, Call& call) {
  const auto state = call.text("state"), code = call.text("code");
  // The same browser that began it: nobody can be signed in as somebody else by a link.
  if (state.empty() || cookie_in(call.request.headers.cookie, kStateCookie) != state) throw Refused("provider_failed", "state");
  if (code.empty()) throw Refused("provider_failed", call.text("error", "code"));
  const auto session = co_await s.provider.finish(state, code, call.request.peer);
  const auto seconds = std::max<std::int64_t>(0, (session.expires_ms - db::now_ms()) / 1000);
  Reply reply;
  reply.content_type = "text/html; charset=utf-8";
  // A page of our own, not a redirect: a SameSite=Strict cookie is not sent along a chain that began elsewhere.
  reply.body = "<!doctype html><meta http-equiv=\"refresh\" content=\"0;url=/\"><title>Headstock</title>";
  reply.headers.emplace_back("Set-Cookie", std::string(session_cookie) + "=" + session.token + "; Path=/; HttpOnly; SameSite=Strict; Max-Age=" +
                                               std::to_string(seconds) + (call.request.secure ? "; Secure" : ""));
  reply.headers.emplace_back("Set-Cookie", state_cookie("", 0, call.request.secure));
  co_return reply;
}

}  // namespace

std::vector<Route> provider_routes(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/sign-in-provider", .role = Role::none, .summary = "Can people sign in elsewhere?",
                    .response = "SignInProvider", .handler = [&s](Call&) -> awaitable<Reply> {
                      const auto found = co_await s.store.run([](db::Database& db) { return integrations::provider_settings(db); });
                      co_return json_reply({{"enabled", !found.issuer.empty()}, {"label", found.label}});
                    }});
  routes.push_back({.method = Method::get, .pattern = "/session/provider", .role = Role::none,
                    .summary = "Sends the browser to the provider", .status = 302, .errors = {"not_found", "provider_failed"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      auto where = co_await return_address(s, call);
                      const auto begun = co_await s.provider.begin(std::move(where));
                      Reply reply = empty_reply();
                      reply.status = 302;
                      reply.headers.emplace_back("Location", begun.url);
                      reply.headers.emplace_back("Set-Cookie", state_cookie(begun.state, 600, call.request.secure));
                      co_return reply;
                    }});
  routes.push_back({.method = Method::get, .pattern = kReturn, .role = Role::none, .summary = "Where the provider sends the browser back to",
                    .response = "bytes", .query = {{"state", "string", "as sent"}, {"code", "string", "of the provider"}},
                    .errors = {"provider_failed", "unknown_person", "wrong_sign_in"},
                    .handler = [&s](Call& call) -> awaitable<Reply> { co_return co_await finish_sign_in(s, call); }});
  const Need need = needs(Action::manage_users);
  routes.push_back({.method = Method::get, .pattern = "/settings/provider", .role = need, .summary = "The OpenID Connect provider",
                    .response = "ProviderSettings", .handler = [&s](Call&) -> awaitable<Reply> {
                      const auto found = co_await s.store.run([](db::Database& db) { return integrations::provider_settings(db); });
                      co_return json_reply(provider_json(found));
                    }});
  routes.push_back({.method = Method::patch, .pattern = "/settings/provider", .role = need,
                    .summary = "Change it; an empty issuer turns it off, an empty secret keeps the old one", .takes = Takes::json,
                    .request = "ProviderSettingsChange", .response = "ProviderSettings", .errors = {"bad_value", "bad_role"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      integrations::ProviderSettings wanted;
                      wanted.issuer = call.body_text("issuer", "");
                      while (wanted.issuer.ends_with('/')) wanted.issuer.pop_back();
                      wanted.client_id = call.body_text("client_id", "");
                      wanted.client_secret = call.body_text("client_secret", "");
                      wanted.label = call.body_text("label", "");
                      wanted.create = call.body.value("create", false);
                      const auto role = access::role_from(call.body_text("role", "viewer"));
                      if (!role) throw Refused("bad_role");
                      wanted.role = *role;
                      const auto actor = actor_of(call);
                      const auto found = co_await s.store.run([&](db::Database& db) {
                        integrations::set_provider(db, actor, wanted);
                        return integrations::provider_settings(db);
                      });
                      co_return json_reply(provider_json(found));
                    }});
  return routes;
}

}  // namespace headstock::api
