// The token file: who may ask (RFC 6750 bearer tokens). Two forms.
//
// A JSON object names tenants, each with a room of its own (tenant.hpp):
//
//   {"tenants": [{
//      "name": "studio",
//      "tokens": [{"sha256": "9f86…", "expires": "2027-01-31T00:00:00Z"}],
//      "scopes": ["read", "fracture", "bake", "admin"],
//      "requests_per_second": 50, "cores": 1.5, "computations": 8,
//      "stored_bytes": 268435456, "cached_bytes": 67108864,
//      "priority": "realtime", "weight": 2}]}
//
// - `name`: at most 64 letters, digits and characters of ._-
// - `tokens`: 1 to 8, so that one can be exchanged; `expires` may be left out.
// - `scopes`: at least one.
// - The numbers may be left out: no limit, and a weight of 1. `priority` is "realtime" or "batch".
//
// Lines `name token` or `name token read-only` are the older, simpler form: the names share everything.
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"
#include "server/tenants/tenant.hpp"

namespace fracture::tenants {

class TokenFile {
 public:
  static constexpr std::size_t kMaxBytes = 1u << 20, kMaxTenants = 1000, kMaxTokens = 8;

  /// kFileAccess, kTooLarge, kBadParameter: one sentence that names the file and the place in it, never a token.
  static Expected<TokenFile> load(const std::string& path);
  static Expected<TokenFile> parse(std::string_view text);

  bool empty() const { return tenants_.empty(); }
  std::size_t size() const { return tenants_.size(); }
  const std::vector<Tenant>& tenants() const { return tenants_; }
  /// Does each name see only what it made or uploaded itself?
  bool isolated() const { return isolated_; }

  struct Match {
    const Tenant* tenant = nullptr;  ///< null: nobody's
    const Token* token = nullptr;
  };
  /// Compares with every token in constant time. Whether it has expired is for the caller to judge.
  Match find(std::string_view token) const;

 private:
  static Expected<TokenFile> parse_lines(std::string_view text);
  static Expected<TokenFile> parse_json(std::string_view text);

  std::vector<Tenant> tenants_;
  bool isolated_ = false;
};

/// The moment of an RFC 3339 time in UTC without fractions ("2027-01-31T00:00:00Z"); nothing for other forms.
std::optional<std::chrono::sys_seconds> parse_utc(std::string_view text);

}  // namespace fracture::tenants
