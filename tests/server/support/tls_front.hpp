// TLS in front of a server without TLS, like a proxy on another machine. Bytes are passed on unchanged.
#pragma once

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/write.hpp>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "common/exchange/asio.hpp"

namespace fracture::test {

namespace asio = protocol::asio;

class TlsFront {
 public:
  /// For the server on this port of 127.0.0.1; certificate and key are PEM files.
  TlsFront(std::uint16_t server, const std::string& certificate, const std::string& key)
      : server_(asio::ip::make_address("127.0.0.1"), server) {
    context_.use_certificate_chain_file(certificate);
    context_.use_private_key_file(key, asio::ssl::context::pem);
    asio::co_spawn(io_, serve(), asio::detached);
    thread_ = std::thread([this] { io_.run(); });
  }
  ~TlsFront() {
    io_.stop();
    thread_.join();
  }
  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }

 private:
  using Error = boost::system::error_code;
  struct Pair {
    Pair(protocol::tcp::socket socket, asio::ssl::context& context, asio::io_context& io)
        : client(std::move(socket), context), server(io) {}
    asio::ssl::stream<protocol::tcp::socket> client;
    protocol::tcp::socket server;
  };
  using PairPtr = std::shared_ptr<Pair>;

  asio::awaitable<void> serve() {
    for (Error error; !error;) {
      auto socket = co_await acceptor_.async_accept(asio::redirect_error(asio::use_awaitable, error));
      if (!error)
        asio::co_spawn(io_, greet(std::make_shared<Pair>(std::move(socket), context_, io_)), asio::detached);
    }
  }
  asio::awaitable<void> greet(PairPtr pair) {
    Error error;
    co_await pair->client.async_handshake(asio::ssl::stream_base::server,
                                          asio::redirect_error(asio::use_awaitable, error));
    if (!error)
      co_await pair->server.async_connect(server_, asio::redirect_error(asio::use_awaitable, error));
    if (error) co_return;
    asio::co_spawn(io_, pass(pair, pair->client, pair->server), asio::detached);
    asio::co_spawn(io_, pass(pair, pair->server, pair->client), asio::detached);
  }
  template <class From, class To>
  static asio::awaitable<void> pass(PairPtr pair, From& from, To& to) {
    std::array<char, 16384> bytes;
    for (Error error; !error;) {
      const std::size_t n = co_await from.async_read_some(asio::buffer(bytes),
                                                          asio::redirect_error(asio::use_awaitable, error));
      if (!error)
        co_await asio::async_write(to, asio::buffer(bytes, n),
                                   asio::redirect_error(asio::use_awaitable, error));
    }
    Error ignored;
    pair->client.lowest_layer().close(ignored);
    pair->server.close(ignored);
  }

  asio::io_context io_;
  asio::ssl::context context_{asio::ssl::context::tls_server};
  const protocol::tcp::endpoint server_;
  protocol::tcp::acceptor acceptor_{io_, {asio::ip::make_address("127.0.0.1"), 0}};
  std::thread thread_;
};

}  // namespace fracture::test
