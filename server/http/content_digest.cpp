#include "server/http/content_digest.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <span>
#include <string>

#include "common/base/text.hpp"
#include "common/digest/digest.hpp"

namespace fracture::http {
namespace {

/// As a byte sequence of RFC 8941: ":<base64>:".
std::string byte_sequence_of(std::string_view body, const EVP_MD* algorithm) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  if (EVP_Digest(body.data(), body.size(), digest, &size, algorithm, nullptr) != 1)
    throw InternalError("a digest cannot be computed");
  return std::string(":").append(base64(std::span(digest, size))) += ':';
}

}  // namespace

std::optional<Problem> check_content_digest(std::string_view field, std::string_view body) {
  while (!field.empty()) {
    std::string_view item = field.substr(0, field.find(','));
    field.remove_prefix(std::min(field.size(), item.size() + 1));
    item = trimmed(item.substr(0, item.find(';')));
    const std::size_t equals = item.find('=');
    const std::string_view value = equals == std::string_view::npos ? item : item.substr(equals + 1);
    if (equals == 0 || equals == std::string_view::npos || value.size() < 2 || value.front() != ':' ||
        value.back() != ':')
      return Problem(HttpProblem::kMalformedRequest,
                     "Content-Digest must be written sha-256=:<base64 of the digest>: (RFC 9530).");
    const std::string_view name = item.substr(0, equals);
    const EVP_MD* const algorithm = name == "sha-256"   ? EVP_sha256()
                                    : name == "sha-512" ? EVP_sha512()
                                                        : nullptr;
    if (!algorithm) continue;
    if (const std::string found = byte_sequence_of(body, algorithm); found != value)
      return Problem(HttpProblem::kContentDigestMismatch,
                     "The " + std::to_string(body.size()) + " bytes of the body have the digest " +
                         std::string(name) + "=" + found + ", and another one was announced.");
  }
  return std::nullopt;
}

}  // namespace fracture::http
