// The token file, which lists the clients that may use the server (RFC 6750 bearer tokens). It has two forms.
//
// The first form is a JSON object with tenants, which are separated from each other (tenant.hpp):
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
// - `tokens`: 1 to 8, so that a token can be replaced; `expires` is optional.
// - `scopes`: at least one.
// - The numbers are optional. Default: no limit, and a weight of 1.
// - `priority`: "realtime" (the default) or "batch".
//
// The second form is older and simpler: lines `name token` or `name token read-only`. These names share everything.
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

  /// Read the file. Errors: kFileAccess, kTooLarge, kBadParameter, with a sentence that names the file and the place in it,
  /// but never contains a token.
  static Expected<TokenFile> load(const std::string& path);
  static Expected<TokenFile> parse(std::string_view text);

  bool empty() const { return tenants_.empty(); }
  std::size_t size() const { return tenants_.size(); }
  const std::vector<Tenant>& tenants() const { return tenants_; }
  /// Returns whether each name sees only what it has made or uploaded itself.
  bool isolated() const { return isolated_; }

  struct Match {
    const Tenant* tenant = nullptr;  ///< null: the token is unknown
    const Token* token = nullptr;
  };
  /// Finds a token. Compares it with every token in constant time. The caller must check whether it has expired.
  Match find(std::string_view token) const;

 private:
  static Expected<TokenFile> parse_lines(std::string_view text);
  static Expected<TokenFile> parse_json(std::string_view text);

  std::vector<Tenant> tenants_;
  bool isolated_ = false;
};

/// Parses an RFC 3339 time in UTC without fractions ("2027-01-31T00:00:00Z"). Returns nothing for any other form.
std::optional<std::chrono::sys_seconds> parse_utc(std::string_view text);

}  // namespace fracture::tenants
