#include "agent/data_desk.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>

#include "agent/retained.hpp"
#include "interpreter/data_values.hpp"

namespace headstock::agent {
namespace {

using nlohmann::json;
constexpr std::size_t kMostValues = 8'000;  // two pages of 400 tools; fits one message

std::optional<std::optional<double>> number_or_null(const json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return std::optional<double>();
  if (!found->is_number()) return std::nullopt;
  return std::optional(found->get<double>());
}

/// @return false when it is no request.
bool read_request(const json& body, operation::EditRequest& request) {
  const auto text = [&body](const char* key) {
    const auto found = body.find(key);
    return found != body.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  request.origin = text("origin");
  request.by = text("by");
  if (const auto number = body.find("request"); number != body.end() && number->is_number_unsigned())
    request.request = number->get<std::uint64_t>();
  const auto values = body.find("values");
  if (values == body.end() || !values->is_array() || values->empty() || values->size() > kMostValues)
    return false;
  for (const json& one : *values) {
    if (!one.is_object() || !one.contains("what") || !one["what"].is_string()) return false;
    const auto before = number_or_null(one, "before"), after = number_or_null(one, "after");
    if (!before || !after) return false;
    request.values.push_back({one["what"].get<std::string>(), *before, *after});
  }
  return !request.origin.empty();
}

json values_now(const std::vector<std::string>& names, const interp::MachineData& data,
                const std::vector<char>& axes) {
  json values = json::object();
  for (const std::string& what : names) {
    const interp::ValueRead read = interp::read_value(data, axes, what);
    values[what] = read.known && read.value ? json(*read.value) : json(nullptr);
  }
  return values;
}

}  // namespace

struct DataDesk::Waiting {
  std::uint64_t version = 0;
  std::vector<std::string> names;
  Done done;
};

DataDesk::DataDesk(operation::Controller& controller, link::Spool& spool)
    : controller_(controller), spool_(spool) {
  for (const machine::Axis& axis : controller.machine().axes) axis_names_.push_back(axis.name);
}

DataDesk::~DataDesk() = default;

void DataDesk::write(const json& body, Done done) {
  operation::EditRequest request;
  if (!read_request(body, request))
    return done({{"accepted", false}, {"reason", "bad_request"}, {"where", ""}, {"values", json::object()}});
  request.parameter_write = parameter_write_;
  std::vector<std::string> names;
  for (const operation::DataEdit& edit : request.values) names.push_back(edit.what);
  const operation::EditResult result = controller_.edit_values(request);
  if (!result.accepted) {
    done({{"accepted", false},
          {"reason", result.reason},
          {"where", result.where},
          {"values", values_now(names, controller_.data(), axis_names_)}});
    return;
  }
  waiting_.push_back({result.version, std::move(names), std::move(done)});
  committed();
}

operation::CommandResult DataDesk::parameter_write(bool on) {
  auto result = controller_.set_parameter_write(on);
  if (result.accepted) parameter_write_ = on;
  return result;
}

void DataDesk::committed() {
  if (waiting_.empty()) return;
  const interp::MachineData stored = read_data(spool_, controller_.machine(), Variables::all);
  std::vector<Waiting> ready;
  for (auto at = waiting_.begin(); at != waiting_.end();) {
    if (stored.version < at->version) {
      ++at;
      continue;
    }
    ready.push_back(std::move(*at));
    at = waiting_.erase(at);
  }
  for (const Waiting& one : ready)
    one.done({{"accepted", true},
              {"reason", ""},
              {"where", ""},
              {"overtaken", stored.version > one.version},
              {"values", values_now(one.names, stored, axis_names_)}});
}

operation::EditResult DataDesk::write_here(const std::string& assignment, const std::string& origin) {
  const std::size_t equals = assignment.find('=');
  if (equals == assignment.npos || equals == 0) return {false, "bad_request", assignment, 0};
  const bool adds = assignment[equals - 1] == '+';
  operation::DataEdit edit;
  edit.what = assignment.substr(0, equals - (adds ? 1 : 0));
  const std::string number = assignment.substr(equals + 1);
  edit.before = interp::read_value(controller_.data(), axis_names_, edit.what).value;
  if (!number.empty()) {
    char* end = nullptr;
    edit.after = std::strtod(number.c_str(), &end);
    if (end != number.c_str() + number.size()) return {false, "bad_value", edit.what, 0};
    if (adds) edit.after = *edit.after + edit.before.value_or(0);
  }
  operation::EditRequest request;
  request.values.push_back(std::move(edit));
  request.origin = origin;
  request.parameter_write = parameter_write_;
  return controller_.edit_values(request);
}

operation::EditResult DataDesk::touch_here(const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == assignment.npos || equals == 0) return {false, "bad_request", assignment, 0};
  const std::string number = assignment.substr(equals + 1);
  char* end = nullptr;
  const double place = std::strtod(number.c_str(), &end);
  if (number.empty() || end != number.c_str() + number.size() || !std::isfinite(place))
    return {false, "bad_value", assignment, 0};
  return controller_.touch({assignment.substr(0, equals), place, {}});
}

std::optional<std::optional<double>> DataDesk::value_here(const std::string& what) const {
  const interp::ValueRead read = interp::read_value(controller_.data(), axis_names_, what);
  if (!read.known) return std::nullopt;
  return read.value;
}

json DataDesk::report() const {
  // A commit with data has events with it: when the sequence is the same before and after, they belong
  // together.
  while (true) {
    const std::uint64_t sequence = spool_.last_sequence();
    const interp::MachineData stored = read_data(spool_, controller_.machine(), Variables::all);
    if (spool_.last_sequence() != sequence) continue;
    json values = json::object();
    interp::each_value(stored, axis_names_,
                       [&values](const std::string& what, double value) { values[what] = value; });
    return {{"sequence", sequence},
            {"version", stored.version},
            {"values", std::move(values)},
            {"parameter_write", parameter_write_}};
  }
}

}  // namespace headstock::agent
