// What is asked over a session and answered later: commands, programs read back, programs a machine asks for.

#include "protocol/process/log.hpp"
#include "protocol/wire/digest.hpp"
#include "protocol/wire/expect.hpp"
#include "server/gateway/agent_session.hpp"

namespace headstock::server {
namespace {

namespace asio = boost::asio;
using nlohmann::json;
using std::chrono::milliseconds;
using wire::Type;

constexpr std::size_t kMaxReadBack = 64u << 20;
constexpr milliseconds kReadBackLimit{60'000};

}  // namespace

asio::awaitable<MachineAnswer> AgentSession::ask(Type type, wire::Command command) {
  const auto self = shared_from_this();
  const std::uint64_t id = command.id = ++asked_;
  const auto answer = std::make_shared<Answer>(connection_->executor());
  answers_[id] = answer;
  connection_->send(type, 0, wire::encode(command));
  const auto until = wire::Connection::Clock::now() + owner_->options().command_limit;
  while (!answer->done) {
    const auto left = until - wire::Connection::Clock::now();
    if (left <= left.zero()) break;
    co_await answer->arrived.wait_for(std::chrono::ceil<milliseconds>(left));
  }
  answers_.erase(id);
  co_return answer->done ? answer->answer : MachineAnswer{false, "timeout"};
}

asio::awaitable<ProgramText> AgentSession::get(std::uint64_t transfer, std::string name) {
  const auto self = shared_from_this();
  const std::uint32_t stream = next_stream();
  const auto reading = std::make_shared<Reading>(connection_->executor());
  reading->program.name = name;
  reading->program.reason = "timeout";
  readings_[stream] = reading;
  reading_streams_[transfer] = stream;
  connection_->send(Type::program_get, stream, wire::encode(wire::ProgramGet{transfer, name}));
  const auto until = wire::Connection::Clock::now() + kReadBackLimit;
  while (!reading->done) {
    const auto left = until - wire::Connection::Clock::now();
    if (left <= left.zero()) break;
    co_await reading->arrived.wait_for(std::chrono::ceil<milliseconds>(left));
  }
  readings_.erase(stream);
  reading_streams_.erase(transfer);
  co_return std::move(reading->program);
}

void AgentSession::on_data(const wire::Frame& frame) {
  const auto found = readings_.find(frame.stream);
  if (found == readings_.end()) return;
  const auto reading = found->second;
  ProgramText& program = reading->program;
  if (frame.type == Type::data) {
    if (program.text.size() + frame.body.size() > kMaxReadBack)
      return connection_->close("a program longer than may be read back");
    program.text += frame.body;
    return;
  }
  wire::expect<wire::DataEnd>(*connection_, frame, [&](const wire::DataEnd& end) {
    program.sha256 = wire::sha256_hex(program.text);
    program.ok = end.bytes == program.text.size() && end.sha256 == program.sha256;
    program.reason = program.ok ? "" : "bad_hash";
    if (!program.ok) program.text.clear();
    reading->done = true;
    reading->arrived.notify();
  });
}

void AgentSession::on_result(const wire::TransferResult& result) {
  const auto found = reading_streams_.find(result.transfer);
  if (found == reading_streams_.end()) return owner_->on_result(*this, result);
  if (result.ok) return;
  if (const auto reading = readings_.find(found->second); reading != readings_.end()) {
    reading->second->program.reason = result.reason;
    reading->second->done = true;
    reading->second->arrived.notify();
  }
}

asio::awaitable<void> AgentSession::program_requested(std::uint64_t request, std::string name) {
  const auto self = shared_from_this();
  ++requests_under_way_;
  MachineAnswer answer{false, "internal"};
  try {
    answer = co_await owner_->host().program_requested(machine_, name);
  } catch (const std::exception& error) {
    log::error("gateway: machine {} asked for {}: {}", machine_, name, error.what());
  }
  --requests_under_way_;
  if (owner_->stopped()) co_return;
  log::info("gateway: machine {} asked for {}: {}", machine_, name,
               answer.accepted ? "sent" : answer.reason);
  connection_->send(Type::request_answer, 0,
                    wire::encode(wire::CommandResult{request, answer.accepted, answer.reason}));
}

void AgentSession::give_up_answers() {
  for (auto& [id, answer] : answers_) {
    if (!answer->done) answer->answer = {false, "link_lost"};
    answer->done = true;
    answer->arrived.notify();
  }
  for (auto& [id, writing] : writings_) {
    if (!writing->result) writing->result = json{{"accepted", false}, {"reason", "link_lost"}};
    writing->arrived.notify();
  }
  for (auto& [stream, reading] : readings_) {
    if (!reading->done) reading->program.reason = "link_lost";
    reading->done = true;
    reading->arrived.notify();
  }
}

// ---- renewal: the old certificate counts until the agent says that the new one is on its disk

}  // namespace headstock::server
