#include "server/http/auth.hpp"

#include <openssl/crypto.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

#include "common/base/digest.hpp"

namespace fracture::http {
namespace {

constexpr std::size_t kMinToken = 16;

bool is_token(std::string_view s) {
  return std::all_of(s.begin(), s.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
           std::string_view("-._~+/=").find(c) != std::string_view::npos;
  });
}

Problem unauthorized(std::string detail, const char* challenge) {
  return Problem(HttpProblem::kUnauthorized, std::move(detail)).with("WWW-Authenticate", challenge);
}

}  // namespace

tl::expected<TokenSet, std::string> TokenSet::load(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file) return tl::unexpected<std::string>(path + " cannot be read");
  auto tokens = parse(text);
  if (!tokens) return tl::unexpected<std::string>(path + tokens.error());
  return tokens;
}

tl::expected<TokenSet, std::string> TokenSet::parse(std::string_view text) {
  TokenSet set;
  std::istringstream lines{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    const auto wrong = [number](const std::string& what) {
      return tl::unexpected<std::string>(" line " + std::to_string(number) + ": " + what);
    };
    std::istringstream words(line);
    std::string name, token, right, more;
    if (!(words >> name) || name.front() == '#') continue;
    if (!(words >> token)) return wrong("must be 'name token' or 'name token read-only'");
    words >> right >> more;
    if ((!right.empty() && right != "read-only") || !more.empty())
      return wrong("must be 'name token' or 'name token read-only'");
    if (token.size() < kMinToken || !is_token(token))
      return wrong("a token needs at least " + std::to_string(kMinToken) +
                   " letters, digits or characters of -._~+/=");
    Holder holder{name, right.empty() ? Right::kAll : Right::kReadOnly, sha256(token).bytes};
    for (const Holder& other : set.holders_)
      if (other.name == name || other.digest == holder.digest)
        return wrong("the name or the token stands in an earlier line, too");
    set.holders_.push_back(std::move(holder));
  }
  if (set.empty()) return tl::unexpected<std::string>(" holds no token");
  return set;
}

OrProblem<std::string> TokenSet::authorize(const RequestHead& head) const {
  if (empty()) return std::string();
  const std::string given = head.field("authorization");
  constexpr std::string_view kScheme = "Bearer ";
  if (given.size() <= kScheme.size() ||
      !equals_ignoring_case(std::string_view(given).substr(0, kScheme.size()), kScheme))
    return tl::unexpected<Problem>(
        unauthorized("This server asks for 'Authorization: Bearer <token>'.", "Bearer realm=\"fracture\""));
  const Digest digest = sha256(std::string_view(given).substr(kScheme.size()));
  const Holder* found = nullptr;
  for (const Holder& holder : holders_)  // to the end, whichever matches
    if (CRYPTO_memcmp(holder.digest.data(), digest.bytes.data(), digest.bytes.size()) == 0) found = &holder;
  if (!found)
    return tl::unexpected<Problem>(unauthorized("The token is not one of this server's.",
                                                "Bearer realm=\"fracture\", error=\"invalid_token\""));
  if (found->right == Right::kReadOnly && head.method != "GET" && head.method != "HEAD")
    return tl::unexpected<Problem>(
        Problem(HttpProblem::kForbidden, "This token may only read (GET and HEAD).")
            .with("WWW-Authenticate", "Bearer realm=\"fracture\", error=\"insufficient_scope\""));
  return found->name;
}

}  // namespace fracture::http
