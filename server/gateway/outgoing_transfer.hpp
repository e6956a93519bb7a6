// A program on its way to one machine, over as many connections as it takes. Private to gateway/.
//
// The sender reads the stored revision in pieces as the machine grants them, and keeps the running hash at
// every piece that is not yet confirmed. A credit names an offset and the hash of everything before it; only
// when both agree does sending go on from there, so the machine gets exactly the stored bytes, whatever was
// cut in between.
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <string>

#include "protocol/wire/connection.hpp"
#include "protocol/wire/digest.hpp"
#include "protocol/wire/messages.hpp"
#include "server/gateway/gateway.hpp"

namespace headstock::server {

class OutgoingTransfer : public std::enable_shared_from_this<OutgoingTransfer> {
 public:
  using Changed = std::function<void(const TransferState&)>;

  OutgoingTransfer(const boost::asio::any_io_executor& executor, TransferState state, std::string name,
                   std::shared_ptr<BlobReader> content, Changed changed);

  const TransferState& state() const { return state_; }
  const std::string& name() const { return name_; }
  bool is_drip() const { return state_.kind == "drip"; }
  bool finished() const { return finished_; }
  /// The machine has agreed to take it (first credit came, or it still had it after a restart).
  bool accepted() const { return accepted_; }
  /// Taken by the machine before the server was restarted: waits for it to come.
  void wait_for_machine();

  /// Sends the opening message on a connection; the machine answers with a credit or a result.
  void open_on(std::shared_ptr<wire::Connection> connection, std::uint32_t stream);
  /// Goes on over a connection without a new opening: the machine has it and says where it stands.
  void resume_on(std::shared_ptr<wire::Connection> connection, std::uint32_t stream,
                 const wire::Credit& credit);
  /// The connection is gone; the transfer waits for the next one.
  void detach();

  void on_credit(const wire::Credit& credit);
  void on_result(const wire::TransferResult& result);
  void fail(const std::string& reason) { end("failed", reason); }
  void cancel(const std::string& reason);

  /// Until the machine accepted, refused, or the connection was lost.
  boost::asio::awaitable<void> answered();
  boost::asio::awaitable<void> ended();

 private:
  /// The running hash after `offset` bytes.
  struct Mark {
    std::uint64_t offset = 0;
    wire::Sha256 digest;
  };

  boost::asio::awaitable<void> send_loop(std::uint64_t attachment);
  boost::asio::awaitable<bool> position(wire::Credit credit, std::uint64_t attachment);
  bool attached(std::uint64_t attachment) const {
    return attachment == attachment_ && connection_ && connection_->open() && !finished_;
  }
  void confirm(const wire::Credit& credit);
  void stop_sending(const std::string& reason);
  void end(const std::string& state, const std::string& reason);
  void set_state(const std::string& state);
  void progress();

  boost::asio::any_io_executor executor_;
  TransferState state_;
  std::string name_;
  std::shared_ptr<BlobReader> content_;
  Changed changed_;
  std::shared_ptr<wire::Connection> connection_;
  std::uint32_t stream_ = 0;
  std::uint64_t attachment_ = 0;  ///< counts connections: a loop of an older one ends
  bool accepted_ = false, finished_ = false, positioned_ = false, positioning_ = false,
       detached_since_open_ = false;
  std::uint64_t sent_ = 0, limit_ = 0;  ///< bytes sent; byte up to which the machine granted
  wire::Sha256 digest_;                 ///< of the bytes sent
  std::deque<Mark> marks_;              ///< ascending, the first is the last confirmed position
  wire::Signal go_on_, answered_, ended_;
  std::chrono::steady_clock::time_point reported_{};
};

}  // namespace headstock::server
