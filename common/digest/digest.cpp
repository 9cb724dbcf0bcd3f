#include "common/digest/digest.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <memory>

#include "common/base/bulk.hpp"
#include "common/base/error.hpp"
#include "common/base/pacer.hpp"

namespace fracture {
namespace {

/// Fetched once, because EVP_sha256() and SHA256() search for their implementation at each use.
const EVP_MD* implementation_of(DigestAlgorithm algorithm) {
  static const EVP_MD* const sha256 = EVP_MD_fetch(nullptr, "SHA256", nullptr);
  static const EVP_MD* const sha512 = EVP_MD_fetch(nullptr, "SHA512", nullptr);
  if (algorithm == DigestAlgorithm::kSha256) return sha256 ? sha256 : EVP_sha256();  // if memory is short
  return sha512 ? sha512 : EVP_sha512();
}

}  // namespace

std::string Digest::hex() const {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string s;
  s.reserve(2 * bytes.size());
  for (const std::uint8_t b : bytes) {
    s += kDigits[b >> 4];
    s += kDigits[b & 15];
  }
  return s;
}

Digest sha256(std::span<const std::byte> data) {
  count_bulk(data.size());
  Digest d;
  if (EVP_Digest(data.data(), data.size(), d.bytes.data(), nullptr,
                 implementation_of(DigestAlgorithm::kSha256), nullptr) != 1)
    throw InternalError("a digest cannot be computed");
  return d;
}

std::vector<std::uint8_t> digest_bytes(DigestAlgorithm algorithm, std::span<const std::byte> data,
                                       const Execution& execution) {
  const EVP_MD* const kind = implementation_of(algorithm);
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(), &EVP_MD_CTX_free);
  count_bulk(data.size());
  bool good = context && EVP_DigestInit_ex(context.get(), kind, nullptr) == 1;
  while (good && !data.empty()) {
    execution.poll();
    const auto block = data.first(std::min(data.size(), kBytesBetweenPolls));
    good = EVP_DigestUpdate(context.get(), block.data(), block.size()) == 1;
    data = data.subspan(block.size());
  }
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(EVP_MD_get_size(kind)));
  if (!good || EVP_DigestFinal_ex(context.get(), bytes.data(), nullptr) != 1)
    throw InternalError("a digest cannot be computed");
  return bytes;
}

Digest sha256(std::span<const std::byte> data, const Execution& execution) {
  const std::vector<std::uint8_t> bytes = digest_bytes(DigestAlgorithm::kSha256, data, execution);
  Digest d;
  std::copy(bytes.begin(), bytes.end(), d.bytes.begin());
  return d;
}

std::string base64(std::span<const std::uint8_t> bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');  // EVP also writes a zero at the end
  const int n = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), bytes.data(),
                                static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(n));
  return text;
}

Digest sha256(std::string_view data) { return sha256(std::as_bytes(std::span(data.data(), data.size()))); }

}  // namespace fracture
