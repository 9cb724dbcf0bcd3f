// A client of plain sockets: sends exactly the bytes it is given, so that a test can be as rude as it likes.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace fracture::test {

struct Reply {
  int status = 0;
  std::map<std::string, std::string> headers;  ///< names in lower case
  std::string body;

  const std::string& header(const std::string& name) const;
  nlohmann::json json() const;
  /// The last path segment of a problem's type; empty when the body is no problem.
  std::string problem() const;
};

class RawClient {
 public:
  /// `from`: the client's own address, any of 127.0.0.0/8; 127.0.0.1 where none is given.
  explicit RawClient(std::uint16_t port, const std::string& from = "");
  ~RawClient();
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  /// False when the server has closed.
  bool send(std::string_view bytes);
  /// A byte of urgent data (RFC 9293, section 3.8.5), beside the stream.
  bool send_urgent(char byte);
  void half_close();
  /// Closes with a reset instead of an orderly end.
  void reset();

  /// The next response, nothing when the server closed before a whole one arrived or `patience` ended.
  std::optional<Reply> receive(bool head_only = false,
                               std::chrono::seconds patience = std::chrono::seconds(30));
  /// Whether this text has come, which stays to be received.
  bool receive_until(const std::string& text, std::chrono::seconds patience = std::chrono::seconds(30));
  /// Everything until the server closes (or `patience` ends, which sets timed_out).
  std::string receive_all(std::chrono::seconds patience = std::chrono::seconds(30));
  /// Reads at most `most` bytes, thrown away, and adds their number; false at the end.
  bool receive_some(std::size_t most, std::size_t& sum);
  bool timed_out() const { return timed_out_; }

 private:
  bool fill(std::chrono::steady_clock::time_point end);
  std::optional<Reply> take_reply(bool head_only);

  int fd_;
  std::string received_;
  bool timed_out_ = false;
};

/// One request on a connection of its own.
Reply ask(std::uint16_t port, const std::string& method, const std::string& target,
          const std::string& fields = "", const std::string& body = "", const std::string& from = "");

}  // namespace fracture::test
