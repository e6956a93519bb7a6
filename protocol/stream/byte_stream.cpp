#include "protocol/stream/byte_stream.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/ssl/host_name_verification.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>

namespace headstock::protocol {

namespace asio = boost::asio;
namespace beast = boost::beast;
constexpr auto tuple = asio::as_tuple(asio::use_awaitable);

struct ByteStream::Kind {
  virtual ~Kind() = default;
  virtual beast::tcp_stream& lowest() = 0;
  virtual beast::ssl_stream<beast::tcp_stream>* tls() { return nullptr; }
  virtual void read(const ReadBuffers& buffers, Done done) = 0;
  virtual void write(const WriteBuffers& buffers, Done done) = 0;

  template <class Stream>
  struct On;
};

template <class Stream>
struct ByteStream::Kind::On final : Kind {
  template <class... Arguments>
  explicit On(Arguments&&... arguments) : stream(std::forward<Arguments>(arguments)...) {}
  beast::tcp_stream& lowest() override { return beast::get_lowest_layer(stream); }
  beast::ssl_stream<beast::tcp_stream>* tls() override {
    if constexpr (std::is_same_v<Stream, beast::tcp_stream>)
      return nullptr;
    else
      return &stream;
  }
  void read(const ReadBuffers& buffers, Done done) override { stream.async_read_some(buffers, std::move(done)); }
  void write(const WriteBuffers& buffers, Done done) override { stream.async_write_some(buffers, std::move(done)); }
  Stream stream;
};

ByteStream::ByteStream(asio::ip::tcp::socket socket, asio::ssl::context* tls) {
  if (tls == nullptr)
    kind_ = std::make_unique<Kind::On<beast::tcp_stream>>(std::move(socket));
  else
    kind_ = std::make_unique<Kind::On<beast::ssl_stream<beast::tcp_stream>>>(std::move(socket), *tls);
}
ByteStream::~ByteStream() = default;
ByteStream::ByteStream(ByteStream&&) noexcept = default;
ByteStream& ByteStream::operator=(ByteStream&&) noexcept = default;

ByteStream::executor_type ByteStream::get_executor() const {
  return kind_->lowest().get_executor();
}

bool ByteStream::secure() const {
  return kind_->tls() != nullptr;
}

beast::tcp_stream& ByteStream::lowest() {
  return kind_->lowest();
}

asio::awaitable<boost::system::error_code> ByteStream::handshake(asio::ssl::stream_base::handshake_type side) {
  if (kind_->tls() == nullptr) co_return boost::system::error_code();
  const auto [error] = co_await kind_->tls()->async_handshake(side, tuple);
  co_return error;
}

asio::awaitable<void> ByteStream::shutdown() {
  if (kind_->tls() != nullptr) co_await kind_->tls()->async_shutdown(tuple);
}

void ByteStream::demand_host(const std::string& host) {
  if (kind_->tls() == nullptr) return;
  kind_->tls()->set_verify_callback(asio::ssl::host_name_verification(host));
  SSL_set_tlsext_host_name(kind_->tls()->native_handle(), host.c_str());
}

void ByteStream::start_read(const ReadBuffers& buffers, Done done) {
  kind_->read(buffers, std::move(done));
}

void ByteStream::start_write(const WriteBuffers& buffers, Done done) {
  kind_->write(buffers, std::move(done));
}

}  // namespace headstock::protocol
