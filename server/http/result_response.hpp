// A result as an HTTP answer.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/content_coding.hpp"
#include "server/http/message.hpp"
#include "server/service/service.hpp"

namespace fracture::http {

/// What of a result is sent, and how: decided from the request's header and the result, before anything is
/// made.
struct Representation {
  bool figures = false;  ///< the extras.fracture object alone
  ContentCoding coding = ContentCoding::kIdentity;
  std::string etag;  ///< with its quotes; each representation has its own
};

/// By Accept-Encoding; a Range is one of the identity, where that is acceptable. Refuses (406) when the field
/// excludes all there is.
OrProblem<Representation> represent(const RequestHead& head, const FractureResult& result, bool figures);

/// Without coding, where the client takes that: what every answer can be sent as.
std::optional<Representation> as_it_is(const RequestHead& head, const FractureResult& result, bool figures);

/// The bytes that the coding is applied to.
std::span<const std::uint8_t> plain_bytes(const FractureResult& result, bool figures);

/// The name in the result cache of what `represent` asks for, where that is compressed.
std::string variant_key(const FractureResult& result, const Representation& representation);

/// All names in the result cache under which the answer of this key may be: its own, and those of variants.
std::vector<std::string> kept_names_of(const std::string& key);

/// Compresses; to be kept under variant_key(). Throws Interrupted.
std::shared_ptr<const FractureResult> make_variant(const FractureResult& result,
                                                   const Representation& representation,
                                                   const Execution& execution);

/// The answer with the headers that depend on the result only. `variant` holds the bytes where they are
/// compressed; null: the answer to a HEAD of what nobody has compressed yet.
Response result_response(const std::shared_ptr<const FractureResult>& result,
                         const Representation& representation,
                         const std::shared_ptr<const FractureResult>& variant);

/// If-Match compares strongly, If-None-Match weakly (RFC 9110, sections 8.8.3.2, 13.1.1 and 13.1.2).
enum class Comparison { kStrong, kWeak };
/// Whether the list of such a field names this entity tag, or is '*'.
bool names_etag(std::string_view field, std::string_view etag, Comparison comparison);

/// RFC 9211: the caches in the order the request meets them, nearest to the computation first.
std::string cache_status(const FractureAnswer& answer);

/// Milliseconds in the queue and of each stage, those that did not run as 0.
std::string server_timing(const FractureAnswer& answer);

}  // namespace fracture::http
