// Bearer tokens (RFC 6750), optional: who may ask, and what. Only digests of the tokens are kept, and they
// are compared in constant time.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "server/http/request_head.hpp"

namespace fracture::http {

class TokenSet {
 public:
  enum class Right { kAll, kReadOnly };  ///< read-only: GET and HEAD
  struct Holder {
    std::string name;
    Right right = Right::kAll;
    std::array<std::uint8_t, 32> digest{};  ///< SHA-256 of the token
  };

  /// Lines `name token` or `name token read-only`; empty lines and those that begin with '#' are skipped. A
  /// token has at least 16 characters of RFC 6750's alphabet. The error names file and line, never a token.
  static tl::expected<TokenSet, std::string> load(const std::string& path);
  static tl::expected<TokenSet, std::string> parse(std::string_view text);

  bool empty() const { return holders_.empty(); }
  std::size_t size() const { return holders_.size(); }

  /// The holder's name, empty when there are no tokens. Refuses with 401 who shows none or a wrong one, and
  /// with 403 who may only read and asks for more.
  OrProblem<std::string> authorize(const RequestHead& head) const;

 private:
  std::vector<Holder> holders_;
};

}  // namespace fracture::http
