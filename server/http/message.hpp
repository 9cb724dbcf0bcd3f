// What a session and the Api hand each other: a request whose header was approved, and its answer.
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

/// A request that may go on: which route, and what its header already decided.
struct Admission {
  const Route* route = nullptr;
  bool head_only = false;  ///< HEAD: the answer without its body
  std::uint64_t max_body = 0;
  std::string segment;  ///< what the braced segment matched
  std::vector<std::pair<std::string, std::string>> query;
  std::size_t representation = 0;  ///< which offered media type was negotiated
};

struct Request {
  RequestHead head;
  Admission admission;
  std::string body;
  std::vector<std::string> pieces;  ///< what came before `body`, of a long one in chunks; joined on the pool
  MemoryBudget::Reservation reservation;                                              ///< for the body
  std::string id;                                                                     ///< X-Request-Id
  std::chrono::steady_clock::time_point received = std::chrono::steady_clock::now();  ///< all of it
  Payer payer;  ///< whose it is: of the token, else of the client's address
  /// Of a name: its place among the name's computations, between the steps that need one (Terms::seat).
  std::shared_ptr<tenants::Account::Seat> seat{};
  std::stop_token client_left{};  ///< also of a request that goes on without its client (goes_on_alone)
  bool on_pool = false;  ///< it is at a thread of the pool, admitted for all that it has brought along

  std::uint64_t body_bytes() const {
    std::uint64_t bytes = body.size();
    for (const std::string& piece : pieces) bytes += piece.size();
    return bytes;
  }
};

/// A body that is not all there when the answer begins: it is written in chunks as it comes.
class BodyStream {
 public:
  virtual ~BodyStream() = default;
  /// Calls `ready` exactly once, from any thread, possibly before returning: with the next bytes, or with
  /// nothing at the end. Not asked again before it has answered. `ready` is dropped uncalled when the server
  /// is destroyed.
  virtual void next(std::function<void(std::optional<std::string>)> ready) = 0;
};

struct Response {
  int status = 200;
  std::string content_type;
  std::vector<std::pair<std::string, std::string>> headers;
  std::shared_ptr<const void> owner;  ///< keeps `body` alive; shared with the cache, never copied
  std::uint64_t owner_bytes = 0;      ///< what that holds, which may be more than `body`
  std::span<const std::uint8_t> body;
  bool length_unknown = false;         ///< the answer to a HEAD says no Content-Length
  std::shared_ptr<BodyStream> stream;  ///< when there is one, it is the body
  double queue_milliseconds = -1;      ///< for the log: waiting for a computing thread; -1: never was

  /// The value of the first header of exactly this name; empty when there is none.
  std::string_view header(std::string_view name) const;

  static Response text(int status, std::string content_type, std::string body);
  static Response json(const nlohmann::ordered_json& document, int status = 200);
  static Response problem(const Problem& problem, std::string_view request_id);
};

}  // namespace fracture::http
