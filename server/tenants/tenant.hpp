// A name in the token file: what it may request, and how much of the server it may use.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace fracture::tenants {

enum class Scope : std::uint8_t {
  kRead = 1,      ///< GET and HEAD answers that the name has made, and meshes that it has uploaded
  kFracture = 2,  ///< store and delete meshes, and fracture while the client waits
  kBake = 4,      ///< store and delete meshes, and start and cancel jobs
  kAdmin = 8,     ///< see and delete what other names have made
};

class Scopes {
 public:
  Scopes() = default;
  Scopes(std::initializer_list<Scope> scopes) {
    for (const Scope scope : scopes) add(scope);
  }
  void add(Scope scope) { bits_ = static_cast<std::uint8_t>(bits_ | static_cast<std::uint8_t>(scope)); }
  bool has(Scope scope) const { return (bits_ & static_cast<std::uint8_t>(scope)) != 0; }
  bool has_any(Scopes of) const { return (bits_ & of.bits_) != 0; }

 private:
  std::uint8_t bits_ = 0;
};

/// The limits of one name. If the file leaves a limit out, only the server's own limits apply.
struct Shares {
  static constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

  std::optional<double> requests_per_second;
  /// Measured processor seconds per second, averaged over about ten seconds.
  std::optional<double> cores;
  std::uint64_t computations = kNoLimit;  ///< queued and running at the same time
  /// Limit on stored meshes in memory, where the least recently used ones are evicted; also a separate limit on jobs on disk.
  std::uint64_t stored_bytes = kNoLimit;
  std::uint64_t cached_bytes = kNoLimit;  ///< limit on answers that the name can fetch again
  bool realtime = true;                   ///< false: realtime requests run as batch work
  double weight = 1;                      ///< weight in the queue, relative to other names
};

struct Token {
  std::array<std::uint8_t, 32> digest{};  ///< SHA-256 of the token; the token itself is not stored
  std::optional<std::chrono::sys_seconds> expires{};  ///< in seconds, because nanoseconds end in 2262
};

struct Tenant {
  std::string name;
  std::vector<Token> tokens;  ///< several, so that a token can be replaced without a gap
  Scopes scopes;
  Shares shares;
};

}  // namespace fracture::tenants
