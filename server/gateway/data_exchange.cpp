// Writing values into a machine's pages: one data_write, one data_result.
#include "server/gateway/agent_session.hpp"

namespace headstock::server {

namespace asio = boost::asio;
using nlohmann::json;
using std::chrono::milliseconds;
using wire::Type;

asio::awaitable<json> AgentSession::write_data(json write) {
  const auto self = shared_from_this();
  const std::uint64_t id = ++asked_;
  write["id"] = id;
  const auto writing = std::make_shared<Writing>(connection_->executor());
  writings_[id] = writing;
  connection_->send(Type::data_write, 0, wire::encode_json(write));
  const auto until = wire::Connection::Clock::now() + owner_->options().command_limit;
  while (!writing->result) {
    const auto left = until - wire::Connection::Clock::now();
    if (left <= left.zero()) break;
    co_await writing->arrived.wait_for(std::chrono::ceil<milliseconds>(left));
  }
  writings_.erase(id);
  if (!writing->result) co_return json{{"accepted", false}, {"reason", "timeout"}};
  co_return std::move(*writing->result);
}

void AgentSession::on_data_result(const wire::Frame& frame) {
  json result;
  if (!json_body(frame, result)) return;
  const auto id = result.find("id");
  const bool sound = id != result.end() && id->is_number_unsigned() && result.contains("accepted") &&
                     result["accepted"].is_boolean() && result.contains("reason") &&
                     result["reason"].is_string() && result.contains("where") &&
                     result["where"].is_string() && result.contains("values") && result["values"].is_object();
  if (!sound) return connection_->close("data_result: id, accepted, reason, where or values missing");
  const auto found = writings_.find(id->get<std::uint64_t>());
  if (found == writings_.end()) return;  // too late: the events tell it
  found->second->result = std::move(result);
  found->second->arrived.notify();
}

}  // namespace headstock::server
