// Results as HTTP answers.
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

/// The part and the encoding of a result to send. Decided from the request's header and the result, before
/// anything is compressed.
struct Representation {
  bool figures = false;  ///< only the extras.fracture object
  ContentCoding coding = ContentCoding::kIdentity;
  std::string etag;  ///< including its quotes; each representation has its own
};

/// Chooses the representation by Accept-Encoding. A Range request gets identity if that is acceptable.
/// Returns 406 if the field excludes all available codings.
OrProblem<Representation> represent(const RequestHead& head, const FractureResult& result, bool figures);

/// Returns the identity representation if the client accepts it. It is available for every answer.
std::optional<Representation> as_it_is(const RequestHead& head, const FractureResult& result, bool figures);

/// Returns the bytes to which the coding is applied.
std::span<const std::uint8_t> plain_bytes(const FractureResult& result, bool figures);

/// Returns the key of a compressed representation in the result cache.
std::string variant_key(const FractureResult& result, const Representation& representation);

/// Returns all keys in the result cache that may hold the answer with this key: its own, and those of its
/// variants.
std::vector<std::string> kept_names_of(const std::string& key);

/// Compresses a result, to be cached under variant_key(). Throws Interrupted.
std::shared_ptr<const FractureResult> make_variant(const FractureResult& result,
                                                   const Representation& representation,
                                                   const Execution& execution);

/// Builds the answer with the headers that depend only on the result. `variant`: the compressed bytes if the
/// representation is compressed. Null is allowed for a HEAD request if they do not exist yet.
Response result_response(const std::shared_ptr<const FractureResult>& result,
                         const Representation& representation,
                         const std::shared_ptr<const FractureResult>& variant);

/// Comparison of entity tags: strong for If-Match, weak for If-None-Match (RFC 9110, sections 8.8.3.2, 13.1.1
/// and 13.1.2).
enum class Comparison { kStrong, kWeak };
/// Returns whether the list in such a field contains this entity tag or is '*'.
bool names_etag(std::string_view field, std::string_view etag, Comparison comparison);

/// Returns Cache-Status (RFC 9211): the caches in the order in which the request meets them, innermost first.
std::string cache_status(const FractureAnswer& answer);

/// Returns the milliseconds in the queue and of each stage; stages that did not run are 0.
std::string server_timing(const FractureAnswer& answer);

}  // namespace fracture::http
