#include "server/tenants/token_file.hpp"

#include <openssl/crypto.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

#include "common/base/words.hpp"
#include "common/digest/digest.hpp"

namespace fracture::tenants {
namespace {

constexpr std::size_t kMinToken = 16;

bool is_token(std::string_view s) {
  return std::all_of(s.begin(), s.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
           std::string_view("-._~+/=").find(c) != std::string_view::npos;
  });
}

}  // namespace

Expected<TokenFile> TokenFile::load(const std::string& path) {
  // Reading a pipe could block the thread that handles SIGHUP, and this thread also handles SIGTERM.
  const std::string file_name = "'" + path + "'";
  if (std::error_code gone; !std::filesystem::is_regular_file(path, gone))
    return fail(ErrorCode::kFileAccess,
                file_name + (gone ? " cannot be read: " + gone.message() + "." : " is not a regular file."));
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::string text(kMaxBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file.is_open() || file.bad())
    return fail(ErrorCode::kFileAccess,
                file_name + " cannot be read: " + std::strerror(errno != 0 ? errno : EIO) + ".");
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kMaxBytes)
    return fail(ErrorCode::kTooLarge,
                file_name + " has more than " + grouped(kMaxBytes) + " bytes, which is the limit.");
  auto tokens = parse(text);
  if (!tokens) return fail(tokens.error().code, file_name + tokens.error().detail + ".");
  return tokens;
}

Expected<TokenFile> TokenFile::parse(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && text[first] == '{') return parse_json(text);
  return parse_lines(text);
}

Expected<TokenFile> TokenFile::parse_lines(std::string_view text) {
  TokenFile file;
  std::istringstream lines{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    const auto wrong = [number](const std::string& what) {
      return fail(ErrorCode::kBadParameter, ", line " + std::to_string(number) + ": " + what);
    };
    std::istringstream words(line);
    std::string name, token, right, more;
    if (!(words >> name) || name.front() == '#') continue;
    if (!(words >> token)) return wrong("the line must be 'name token' or 'name token read-only'");
    words >> right >> more;
    if ((!right.empty() && right != "read-only") || !more.empty())
      return wrong("the line must be 'name token' or 'name token read-only'");
    if (token.size() < kMinToken || !is_token(token))
      return wrong("a token needs at least " + std::to_string(kMinToken) +
                   " characters: letters, digits or any of -._~+/=");
    Tenant tenant;
    tenant.name = name;
    tenant.tokens = {{sha256(token).bytes, std::nullopt}};
    tenant.scopes = {Scope::kRead};
    if (right.empty()) tenant.scopes = {Scope::kRead, Scope::kFracture, Scope::kBake};
    for (const Tenant& other : file.tenants_)
      if (other.name == name || other.tokens.front().digest == tenant.tokens.front().digest)
        return wrong("the name or the token is already in an earlier line; each may occur only once");
    if (file.size() == kMaxTenants)
      return wrong("the file has more than " + std::to_string(kMaxTenants) + " names, which is the limit");
    file.tenants_.push_back(std::move(tenant));
  }
  if (file.empty()) return fail(ErrorCode::kBadParameter, " contains no token");
  return file;
}

TokenFile::Match TokenFile::find(std::string_view given) const {
  const Digest digest = sha256(given);
  Match match;
  for (const Tenant& tenant : tenants_)  // does not stop at a match, so that timing reveals nothing
    for (const Token& token : tenant.tokens)
      if (CRYPTO_memcmp(token.digest.data(), digest.bytes.data(), digest.bytes.size()) == 0)
        match = {&tenant, &token};
  return match;
}

}  // namespace fracture::tenants
