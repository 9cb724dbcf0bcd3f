// One name of the token file: what it may ask, how much of the server is its own.
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
  kRead = 1,      ///< GET and HEAD of what the name has made or uploaded
  kFracture = 2,  ///< store and delete meshes, fracture while the client waits
  kBake = 4,      ///< store and delete meshes, start and cancel jobs
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

/// What one name may take at most. Left out of the file: the server's own limits alone.
struct Shares {
  static constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

  std::optional<double> requests_per_second;
  /// Processor seconds a second, measured, over some ten seconds.
  std::optional<double> cores;
  std::uint64_t computations = kNoLimit;  ///< queued and running at the same time
  /// Of meshes in memory, of which the least recently used leave for new ones; and, for itself, of jobs on the disk.
  std::uint64_t stored_bytes = kNoLimit;
  std::uint64_t cached_bytes = kNoLimit;  ///< of answers that the name can fetch again
  bool realtime = true;                   ///< false: what asks for realtime is done as batch
  double weight = 1;                      ///< of its turn in the queue, beside the others'
};

struct Token {
  std::array<std::uint8_t, 32> digest{};              ///< SHA-256 of the token, which itself is nowhere
  std::optional<std::chrono::sys_seconds> expires{};  ///< seconds reach beyond 2262, nanoseconds do not
};

struct Tenant {
  std::string name;
  std::vector<Token> tokens;  ///< several, so that they can be exchanged without a gap
  Scopes scopes;
  Shares shares;
};

}  // namespace fracture::tenants
