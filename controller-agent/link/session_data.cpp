// Offsets, parameters and variables on the link: the report of what the machine has, and what is written to
// it.

#include <nlohmann/json.hpp>

#include "link/session.hpp"
#include "protocol/process/log.hpp"
#include "protocol/wire/digest.hpp"

namespace headstock::link {

using nlohmann::json;
using wire::Type;

/// The events tell every change; the report shows now and then that nothing else has changed.
constexpr std::chrono::seconds kReportInterval{5};

/// Only when the server has taken every event that led to these values: otherwise it would see differences
/// that the events on their way explain.
void Session::report_data() {
  if (!active() || parts_->spool.pending() != 0) return;
  const auto now = std::chrono::steady_clock::now();
  if (reported_ != std::chrono::steady_clock::time_point{} && now - reported_ < kReportInterval) return;
  const json report = parts_->host.data_report();
  if (!report.is_object()) return;
  if (report.value("sequence", std::uint64_t{0}) > acknowledged_)
    return;  // one came in between: after its ack
  reported_ = now;
  const std::string body = wire::encode_json(report);
  // What has not changed is not told again.
  const std::string digest = wire::sha256_hex(wire::encode_json(report.value("values", json::object())) +
                                              (report.value("parameter_write", false) ? "+" : "-"));
  if (digest == reported_values_) return;
  reported_values_ = digest;
  if (body.size() > wire::kMaxControlBytes) return log::error("link: too many values for one report");
  connection_->send(Type::data_report, 0, body);
}

void Session::on_data_write(const wire::Frame& frame) {
  json request;
  std::string wrong = wire::decode_json(frame.body, request);
  if (wrong.empty() && !(request.is_object() && request.contains("id") && request["id"].is_number_unsigned()))
    wrong = "no id";
  if (!wrong.empty()) return connection_->close("data_write: " + wrong);
  const std::weak_ptr<Session> self = weak_from_this();
  parts_->host.write_data(request, [self, id = request["id"]](json result) {
    const auto session = self.lock();
    if (!session || !session->active()) return;  // the server learns it from the events and the next report
    result["id"] = id;
    session->connection_->send(Type::data_result, 0, wire::encode_json(result));
  });
}

void LinkHost::write_data(const json& request, std::function<void(json)> done) {
  json values = json::object();
  for (const json& one : request.value("values", json::array()))
    if (one.is_object() && one.contains("what") && one["what"].is_string())
      values[one["what"].get<std::string>()] = nullptr;
  done({{"accepted", false}, {"reason", "not_supported"}, {"where", ""}, {"values", std::move(values)}});
}

json LinkHost::data_report() {
  return nullptr;
}

}  // namespace headstock::link
