#include "server/http/result_response.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "common/pipeline/algorithm_version.hpp"

namespace fracture::http {
namespace {

/// Smaller answers are not worth compressing; larger ones would occupy a thread for too long.
constexpr std::size_t kLeastCompressed = 1u << 10, kMostCompressed = 64u << 20;

std::string milliseconds(double ms) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", ms);
  return text;
}

std::string etag_of(const FractureResult& result, const Representation& representation) {
  std::string etag(1, '"');
  etag += result.key;
  if (representation.figures) etag += ".figures";
  if (representation.coding != ContentCoding::kIdentity)
    etag.append(1, '.').append(name_of(representation.coding));
  return etag += '"';
}

std::string variant_name(const std::string& key, bool figures, ContentCoding coding) {
  return key + (figures ? ".figures." : ".") + std::string(name_of(coding));
}

}  // namespace

bool names_etag(std::string_view field, std::string_view etag, Comparison comparison) {
  while (!field.empty()) {
    std::string_view item = field.substr(0, field.find(','));
    field.remove_prefix(std::min(field.size(), item.size() + 1));
    while (!item.empty() && item.front() == ' ') item.remove_prefix(1);
    while (!item.empty() && item.back() == ' ') item.remove_suffix(1);
    if (comparison == Comparison::kWeak && item.substr(0, 2) == "W/") item.remove_prefix(2);
    if (item == "*" || item == etag) return true;
  }
  return false;
}

OrProblem<Representation> represent(const RequestHead& head, const FractureResult& result, bool figures) {
  const CodingWishes wishes = coding_wishes(head.field("accept-encoding"));
  const std::size_t size = plain_bytes(result, figures).size();
  const bool large = size > kMostCompressed,
             plain = !head.field("range").empty() || size < kLeastCompressed || large;
  Representation chosen;
  chosen.figures = figures;
  if (!(plain && wishes.accepts(ContentCoding::kIdentity))) {
    const auto best = wishes.best();
    if (!best || large)
      return refuse(HttpProblem::kNotAcceptable,
                    large ? "An answer of " + std::to_string(size) +
                                " bytes is too large to be compressed; the limit is " +
                                std::to_string(kMostCompressed) + ", and Accept-Encoding excludes identity."
                          : "Accept-Encoding excludes all available codings: zstd, gzip, identity.");
    chosen.coding = *best;
  }
  chosen.etag = etag_of(result, chosen);
  return chosen;
}

std::optional<Representation> as_it_is(const RequestHead& head, const FractureResult& result, bool figures) {
  if (!coding_wishes(head.field("accept-encoding")).accepts(ContentCoding::kIdentity)) return std::nullopt;
  Representation plain;
  plain.figures = figures;
  plain.etag = etag_of(result, plain);
  return plain;
}

std::span<const std::uint8_t> plain_bytes(const FractureResult& result, bool figures) {
  return figures ? result.bytes_of(result.figures) : std::span(result.file);
}

std::string variant_key(const FractureResult& result, const Representation& representation) {
  return variant_name(result.key, representation.figures, representation.coding);
}

std::vector<std::string> kept_names_of(const std::string& key) {
  std::vector<std::string> names = {key};
  for (const bool figures : {false, true})
    for (const ContentCoding coding : {ContentCoding::kGzip, ContentCoding::kZstd})
      names.push_back(variant_name(key, figures, coding));
  return names;
}

std::shared_ptr<const FractureResult> make_variant(const FractureResult& result,
                                                   const Representation& representation,
                                                   const Execution& execution) {
  auto variant = std::make_shared<FractureResult>();
  variant->key = variant_key(result, representation);
  variant->mesh_digest = result.mesh_digest;
  variant->format = result.format;
  variant->file = encode_body(plain_bytes(result, representation.figures), representation.coding, execution);
  variant->file_digest = sha256(std::as_bytes(std::span(variant->file)), execution);
  return variant;
}

Response result_response(const std::shared_ptr<const FractureResult>& result,
                         const Representation& representation,
                         const std::shared_ptr<const FractureResult>& variant) {
  const bool figures = representation.figures, plain = representation.coding == ContentCoding::kIdentity;
  if (figures && result->figures.size == 0) throw InternalError("a result without figures");
  Response response;
  response.content_type = figures                                 ? "application/json"
                          : result->format == OutputFormat::kGltf ? "model/gltf+json"
                                                                  : "model/gltf-binary";
  response.headers.emplace_back("ETag", representation.etag);
  response.headers.emplace_back("Content-Location", "/fractures/sha256:" + result->key);
  response.headers.emplace_back("Vary", "Accept, Accept-Encoding");
  response.headers.emplace_back("Fracture-Algorithm", std::to_string(kAlgorithmVersion));
  if (!plain) response.headers.emplace_back("Content-Encoding", name_of(representation.coding));
  // RFC 9530: the digest of the encoded representation, even if only a range of it is sent.
  const Digest* digest = nullptr;
  if (plain) {
    response.body = plain_bytes(*result, figures);
    response.owner = result;
    response.owner_bytes = memory_size(*result);
    digest = figures ? &result->figures_digest : &result->file_digest;
  } else if (variant) {
    response.body = variant->file;
    response.owner = variant;
    response.owner_bytes = memory_size(*variant);
    digest = &variant->file_digest;
  } else {
    response.length_unknown = true;
  }
  if (digest) response.headers.emplace_back("Repr-Digest", "sha-256=:" + base64(digest->bytes) + ":");
  return response;
}

std::string cache_status(const FractureAnswer& answer) {
  std::string value;
  const auto add = [&](const char* name, CacheOutcome outcome) {
    if (outcome == CacheOutcome::kNotConsulted) return;
    if (!value.empty()) value += ", ";
    value += name;
    if (outcome == CacheOutcome::kHit) value += "; hit";
    if (outcome == CacheOutcome::kMissStored) value += "; fwd=miss; stored";
    if (outcome == CacheOutcome::kMissNotStored) value += "; fwd=miss";
    if (outcome == CacheOutcome::kCollapsed) value += "; fwd=miss; collapsed";
  };
  add("redis", answer.redis_cache);
  add("disk", answer.disk_cache);
  add("mesh", answer.mesh_cache);
  add("diagram", answer.diagram_cache);
  add("result", answer.result_cache);
  return value;
}

std::string server_timing(const FractureAnswer& answer) {
  std::string value = "queue;dur=" + milliseconds(std::max(0.0, answer.queue_milliseconds));
  for (const StageRow& row : kStages)
    value += std::string(", ") + row.name + ";dur=" + milliseconds(answer.timings.milliseconds(row.stage));
  return value + ", work;dur=" + milliseconds(answer.work_milliseconds);
}

}  // namespace fracture::http
