// Data that a session and the Api exchange: a request with an approved header, and its answer.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/http/problem.hpp"
#include "server/http/request_head.hpp"
#include "server/http/routes.hpp"
#include "server/service/memory_budget.hpp"
#include "server/service/payer.hpp"

namespace fracture::http {

/// An admitted request: its route, and what was decided from its header.
struct Admission {
  const Route* route = nullptr;
  bool head_only = false;  ///< HEAD: answer without a body
  std::uint64_t max_body = 0;
  std::string segment;  ///< the text that matched the segment in braces
  std::vector<std::pair<std::string, std::string>> query;
  std::size_t representation = 0;  ///< index of the negotiated media type among the route's offers
};

struct Request {
  RequestHead head;
  Admission admission;
  std::string body;
  std::vector<std::string> pieces;        ///< parts of a long chunked body before `body`, joined on the pool
  MemoryBudget::Reservation reservation;  ///< for the body
  std::string id;                         ///< X-Request-Id
  std::string address;                    ///< client_of() its address, for which its answer is counted
  std::chrono::steady_clock::time_point received = std::chrono::steady_clock::now();  ///< when complete
  Payer payer;  ///< account of the token, or else the client's address
  /// For requests with a name: its seat among the name's computations, kept between the steps that need one
  /// (Terms::seat).
  std::shared_ptr<tenants::Account::Seat> seat{};
  std::stop_token client_left{};  ///< stopped even if the request goes on without its client (goes_on_alone)
  bool on_pool = false;           ///< already runs on a pool thread, with its whole input admitted

  std::uint64_t body_bytes() const {
    std::uint64_t bytes = body.size();
    for (const std::string& piece : pieces) bytes += piece.size();
    return bytes;
  }
};

/// A body that is still growing when the answer begins. It is written in chunks as data arrives.
class BodyStream {
 public:
  virtual ~BodyStream() = default;
  /// Calls `ready` exactly once, from any thread, possibly before returning: with the next bytes, or with
  /// nothing at the end. Must not be called again before `ready` was called. If the server is destroyed,
  /// `ready` is dropped without a call.
  virtual void next(std::function<void(std::optional<std::string>)> ready) = 0;
};

struct Response {
  int status = 200;
  std::string content_type;
  std::vector<std::pair<std::string, std::string>> headers;
  std::shared_ptr<const void> owner;  ///< keeps `body` alive; shared with the cache, not copied
  std::uint64_t owner_bytes = 0;      ///< bytes that `owner` keeps alive, possibly more than `body`
  std::span<const std::uint8_t> body;
  bool length_unknown = false;         ///< for HEAD: send no Content-Length
  std::shared_ptr<BodyStream> stream;  ///< if set, it replaces `body`
  double queue_milliseconds = -1;      ///< for the log: wait for a computing thread; -1: did not wait

  /// Returns the value of the first header with exactly this name, or an empty string.
  std::string_view header(std::string_view name) const;

  static Response text(int status, std::string content_type, std::string body);
  static Response json(const nlohmann::ordered_json& document, int status = 200);
  static Response problem(const Problem& problem, std::string_view request_id);
};

}  // namespace fracture::http
