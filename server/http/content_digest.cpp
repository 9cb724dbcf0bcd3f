#include "server/http/content_digest.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <string>

#include "common/base/text.hpp"
#include "common/base/words.hpp"
#include "common/digest/digest.hpp"

namespace fracture::http {
namespace {

struct Announced {
  std::string_view name;
  DigestAlgorithm algorithm;
  std::string_view value;  ///< a byte sequence (RFC 8941), ":<base64>:"; empty: none
};

}  // namespace

std::optional<Problem> check_content_digest(std::string_view field, std::string_view body,
                                            const Execution& execution) {
  // If a name is repeated, the last value counts (RFC 8941, section 4.2.2). So the body is hashed at most
  // once per algorithm, however long the field is.
  std::array<Announced, 2> known{
      {{"sha-256", DigestAlgorithm::kSha256, {}}, {"sha-512", DigestAlgorithm::kSha512, {}}}};
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
    for (Announced& one : known)
      if (one.name == item.substr(0, equals)) one.value = value;
  }
  for (const Announced& one : known) {
    if (one.value.empty()) continue;
    const auto bytes = std::as_bytes(std::span(body.data(), body.size()));
    const std::string found = ":" + base64(digest_bytes(one.algorithm, bytes, execution)) + ":";
    if (found != one.value)
      return Problem(
          HttpProblem::kContentDigestMismatch,
          "The body (" + counted(body.size(), "byte", "bytes") + ") has the digest " + std::string(one.name) +
              "=" + found +
              ", but the request announces another digest. Send the body again, or correct Content-Digest.");
  }
  return std::nullopt;
}

}  // namespace fracture::http
