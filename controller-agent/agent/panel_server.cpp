#include "agent/panel_server.hpp"

#include <sys/stat.h>

#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>
#include <istream>
#include <stdexcept>

namespace headstock::agent {

namespace asio = boost::asio;
using asio::local::stream_protocol;

namespace {

constexpr std::size_t kLongestRequest = 4096;

/// One person's connection; lives as long as it is used.
class Conversation : public std::enable_shared_from_this<Conversation> {
 public:
  Conversation(stream_protocol::socket socket, const PanelServer::Handler& handler)
      : socket_(std::move(socket)), handler_(handler), input_(kLongestRequest) {}

  void read() {
    asio::async_read_until(socket_, input_, '\n', [self = shared_from_this()](auto error, std::size_t) {
      if (error) return;
      std::istream in(&self->input_);
      std::string line;
      std::getline(in, line);
      self->answer_ = self->handler_(line) + "\n";
      asio::async_write(self->socket_, asio::buffer(self->answer_), [self](auto failed, std::size_t) {
        if (!failed) self->read();
      });
    });
  }

 private:
  stream_protocol::socket socket_;
  const PanelServer::Handler& handler_;
  asio::streambuf input_;
  std::string answer_;
};

}  // namespace

struct PanelServer::Impl : std::enable_shared_from_this<Impl> {
  Impl(asio::io_context& io, std::filesystem::path path, Handler answer)
      : file(std::move(path)), handler(std::move(answer)), acceptor(io) {}

  void accept() {
    acceptor.async_accept([self = shared_from_this()](auto error, stream_protocol::socket socket) {
      if (error) return;
      std::make_shared<Conversation>(std::move(socket), self->handler)->read();
      self->accept();
    });
  }

  std::filesystem::path file;
  Handler handler;
  stream_protocol::acceptor acceptor;
};

PanelServer::PanelServer(asio::io_context& io, std::filesystem::path socket, Handler handler)
    : impl_(std::make_shared<Impl>(io, std::move(socket), std::move(handler))) {
  // The folder is locked by this agent, so a socket that is there was left by one that died.
  std::error_code ignored;
  std::filesystem::remove(impl_->file, ignored);
  try {
    const stream_protocol::endpoint endpoint(impl_->file.string());
    impl_->acceptor.open(endpoint.protocol());
    const mode_t before = ::umask(0077);
    boost::system::error_code error;
    impl_->acceptor.bind(endpoint, error);
    ::umask(before);
    if (error) throw boost::system::system_error(error);
    impl_->acceptor.listen();
  } catch (const boost::system::system_error& error) {
    throw std::runtime_error("cannot make the panel's socket " + impl_->file.string() + ": " + error.code().message());
  }
}

PanelServer::~PanelServer() {
  boost::system::error_code ignored;
  impl_->acceptor.close(ignored);
  std::error_code also_ignored;
  std::filesystem::remove(impl_->file, also_ignored);
}

void PanelServer::start() { impl_->accept(); }

}  // namespace headstock::agent
