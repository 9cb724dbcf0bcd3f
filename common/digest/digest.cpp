#include "common/digest/digest.hpp"

#include <openssl/evp.h>
#include <openssl/sha.h>

namespace fracture {

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
  Digest d;
  SHA256(reinterpret_cast<const unsigned char*>(data.data()), data.size(), d.bytes.data());
  return d;
}

std::string base64(std::span<const std::uint8_t> bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');  // and a zero at the end, which EVP writes
  const int n = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), bytes.data(),
                                static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(n));
  return text;
}

Digest sha256(std::string_view data) { return sha256(std::as_bytes(std::span(data.data(), data.size()))); }

}  // namespace fracture
