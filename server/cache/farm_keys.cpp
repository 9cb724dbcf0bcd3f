#include "server/cache/farm_keys.hpp"

#include <openssl/core_names.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/params.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

constexpr std::string_view kSignatureMagic = "FRS1";
using Signature = std::array<std::uint8_t, 32>;
static_assert(FarmKeys::kHead == kSignatureMagic.size() + sizeof(Signature));

Signature sign(const std::string& key, const SignedAs& as, std::initializer_list<FarmKeys::Bytes> bytes,
               const Execution& execution) {
  // Fetched once, because a fetch locks a table in the library.
  static const std::unique_ptr<EVP_MAC, decltype(&EVP_MAC_free)> hmac(EVP_MAC_fetch(nullptr, "HMAC", nullptr),
                                                                      &EVP_MAC_free);
  const std::unique_ptr<EVP_MAC_CTX, decltype(&EVP_MAC_CTX_free)> context(EVP_MAC_CTX_new(hmac.get()),
                                                                          &EVP_MAC_CTX_free);
  char name[] = "SHA256";
  const OSSL_PARAM parameters[] = {OSSL_PARAM_construct_utf8_string(OSSL_MAC_PARAM_DIGEST, name, 0),
                                   OSSL_PARAM_construct_end()};
  std::string about = "fracture cache entry\n";  // unambiguous, because no part contains a line break
  about.append(as.tier).append("\n").append(as.key).append("\n").append(std::to_string(as.algorithm)) += '\n';
  Signature signature;
  std::size_t size = 0;
  const auto* raw_key = reinterpret_cast<const unsigned char*>(key.data());
  const auto* raw_about = reinterpret_cast<const unsigned char*>(about.data());
  bool good = context && EVP_MAC_init(context.get(), raw_key, key.size(), parameters) == 1 &&
              EVP_MAC_update(context.get(), raw_about, about.size()) == 1;
  for (const FarmKeys::Bytes part : bytes)
    each_piece(execution, part, [&](FarmKeys::Bytes piece) {
      good = good && EVP_MAC_update(context.get(), piece.data(), piece.size()) == 1;
    });
  if (!good || EVP_MAC_final(context.get(), signature.data(), &size, signature.size()) != 1 ||
      size != signature.size())
    throw std::runtime_error("HMAC-SHA256 cannot be computed");
  return signature;
}

}  // namespace

Expected<FarmKeys> FarmKeys::load(const std::string& path) {
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(path, error);  // it opens, but reading it throws
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (is_folder) errno = EISDIR;
  if (!file || is_folder)
    return fail(ErrorCode::kFileAccess,
                "'" + path + "' cannot be read: " + std::strerror(errno != 0 ? errno : EIO) + ".");
  auto keys = parse(std::string{std::istreambuf_iterator<char>(file), {}});
  if (!keys) return fail(keys.error().code, "'" + path + "': " + keys.error().detail + ".");
  return keys;
}

Expected<FarmKeys> FarmKeys::parse(std::string_view text) {
  const auto wrong = [](std::string why) { return fail(ErrorCode::kBadParameter, std::move(why)); };
  FarmKeys keys;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
    if (line.empty() || line.front() == '#') continue;
    const std::string where = "line " + std::to_string(number);
    if (line.size() < kMinCharacters)
      return wrong(where + " has fewer than " + std::to_string(kMinCharacters) +
                   " characters (openssl rand -hex 32 makes a key)");
    if (keys.keys_.size() == kMaxKeys)
      return wrong(where +
                   " is a third key, but the limit is two: the first one signs, and both are accepted");
    keys.keys_.emplace_back(line);
  }
  if (keys.empty()) return wrong("it contains no key");
  return keys;
}

std::string FarmKeys::head(const SignedAs& as, std::initializer_list<Bytes> bytes) const {
  const Signature signature = sign(keys_.at(0), as, bytes, kUninterrupted);
  std::string head(kSignatureMagic);
  head.append(reinterpret_cast<const char*>(signature.data()), signature.size());
  return head;
}

std::optional<FarmKeys::Bytes> FarmKeys::open(const SignedAs& as, Bytes stored,
                                              const Execution& execution) const {
  if (stored.size() < kHead ||
      std::memcmp(stored.data(), kSignatureMagic.data(), kSignatureMagic.size()) != 0)
    return std::nullopt;
  const Bytes bytes = stored.subspan(kHead);
  for (const std::string& key : keys_) {
    const Signature right = sign(key, as, {bytes}, execution);
    // Compares in constant time, so that timing does not reveal how much of a guess was right.
    if (CRYPTO_memcmp(right.data(), stored.data() + kSignatureMagic.size(), right.size()) == 0) return bytes;
  }
  return std::nullopt;
}

}  // namespace fracture
