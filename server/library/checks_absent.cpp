// Built only while the controller's own library is missing from the build: every check then fails and says
// so.
#include "db/refusal.hpp"
#include "server/library/checks.hpp"

namespace headstock::library {

std::string checker_version() {
  return "none";
}

CheckResult run_check(const CheckJob&) {
  CheckResult result;
  result.findings.push_back({0, 0, "internal",
                             "This server was built without the controller and cannot check programs.",
                             "本服务器未包含控制器程序库，无法检查程序。"});
  return result;
}

Backplot run_backplot(const CheckJob&, std::int64_t) {
  throw db::Refusal("check_failed", "built without the controller");
}

Restart run_restart(const CheckJob&, std::int64_t) {
  throw db::Refusal("check_failed", "built without the controller");
}

}  // namespace headstock::library
