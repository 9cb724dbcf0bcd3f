// A client with plain sockets: it sends exactly the given bytes, so that a test can be as rude as it likes.
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
  /// The last path segment of a problem's type; empty if the body is not a problem.
  std::string problem() const;
};

class RawClient {
 public:
  /// `from` is the client's own address, any of 127.0.0.0/8. Default: 127.0.0.1.
  explicit RawClient(std::uint16_t port, const std::string& from = "");
  ~RawClient();
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  /// Returns false if the server has closed.
  bool send(std::string_view bytes);
  /// Sends a byte of urgent data (RFC 9293, section 3.8.5), outside the stream.
  bool send_urgent(char byte);
  void half_close();
  /// Closes with a reset instead of an orderly end.
  void reset();

  /// Returns the next response, or nothing if the server closed before the whole response arrived or
  /// `patience` ended.
  std::optional<Reply> receive(bool head_only = false,
                               std::chrono::seconds patience = std::chrono::seconds(30));
  /// Returns whether this text has arrived. The text remains to be received.
  bool receive_until(const std::string& text, std::chrono::seconds patience = std::chrono::seconds(30));
  /// Returns everything until the server closes, or until `patience` ends, which sets timed_out.
  std::string receive_all(std::chrono::seconds patience = std::chrono::seconds(30));
  /// Reads and discards at most `most` bytes, and adds their number to `sum`. Returns false at the end.
  bool receive_some(std::size_t most, std::size_t& sum);
  bool timed_out() const { return timed_out_; }

 private:
  bool fill(std::chrono::steady_clock::time_point end);
  std::optional<Reply> take_reply(bool head_only);

  int fd_;
  std::string received_;
  bool timed_out_ = false;
};

/// Sends a single request on its own connection.
Reply ask(std::uint16_t port, const std::string& method, const std::string& target,
          const std::string& fields = "", const std::string& body = "", const std::string& from = "");

}  // namespace fracture::test
