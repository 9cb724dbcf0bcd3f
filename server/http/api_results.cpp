// Results as resources, and the header fields that every answer with a result has.
#include "server/http/result_response.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <charconv>
#include <cstdio>

#include "server/http/accept.hpp"
#include "server/http/api.hpp"

namespace fracture::http {
namespace {

std::string milliseconds(double ms) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", ms);
  return text;
}

std::string base64(std::span<const std::uint8_t> bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');  // and a zero at the end, which EVP writes
  const int n = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), bytes.data(),
                                static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(n));
  return text;
}

/// If-None-Match (RFC 9110, section 13.1.2): weak comparison against a list, or '*'.
bool none_match_fails(std::string_view field, std::string_view etag) {
  while (!field.empty()) {
    std::string_view item = field.substr(0, field.find(','));
    field.remove_prefix(std::min(field.size(), item.size() + 1));
    while (!item.empty() && item.front() == ' ') item.remove_prefix(1);
    while (!item.empty() && item.back() == ' ') item.remove_suffix(1);
    if (item.substr(0, 2) == "W/") item.remove_prefix(2);
    if (item == "*" || item == etag) return true;
  }
  return false;
}

}  // namespace

Response result_response(const std::shared_ptr<const FractureResult>& result, std::size_t representation) {
  Response response;
  if (representation == kAsFigures) {
    response = Response::text(200, "application/json", figures_of(*result).dump() + "\n");
  } else {
    response.content_type = result->format == OutputFormat::kGltf ? "model/gltf+json" : "model/gltf-binary";
    response.body = result->file;
    response.owner = result;
  }
  response.headers.emplace_back("ETag",
                                "\"" + result->key + (representation == kAsFigures ? ".json\"" : "\""));
  response.headers.emplace_back("Content-Location", "/fractures/sha256:" + result->key);
  if (representation != kAsFigures) {
    // RFC 9530: of the representation, whatever range of it is sent.
    const auto& digest = result->file_digest.bytes;
    response.headers.emplace_back("Repr-Digest", "sha-256=:" + base64(digest) + ":");
  }
  response.headers.emplace_back("Vary", "Accept");
  response.headers.emplace_back("Fracture-Algorithm", std::to_string(kAlgorithmVersion));
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
  for (const char* stage : {"import", "prepare", "tetrahedralize", "clip", "encode"})
    value += std::string(", ") + stage + ";dur=" + milliseconds(answer.timings.milliseconds(stage));
  return value + ", work;dur=" + milliseconds(answer.work_milliseconds);
}

namespace {

Problem no_result() {
  return Problem(
      HttpProblem::kNotFound,
      "This result is not (or no longer) in the cache. Asking for the same fracture makes it again.");
}

struct Range {
  std::size_t first, length;
};
enum class RangeVerdict { kWhole, kPart, kUnsatisfiable };

std::optional<std::uint64_t> digits(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// One range of bytes (RFC 9110, section 14.2). Several ranges, other units and malformed fields are answered
/// with the whole, as that section allows.
RangeVerdict range_of(std::string_view field, std::size_t size, Range& range) {
  constexpr std::string_view kUnit = "bytes=";
  if (field.substr(0, kUnit.size()) != kUnit || field.find(',') != std::string_view::npos)
    return RangeVerdict::kWhole;
  field.remove_prefix(kUnit.size());
  const std::size_t dash = field.find('-');
  if (dash == std::string_view::npos) return RangeVerdict::kWhole;
  const std::string_view before = field.substr(0, dash), after = field.substr(dash + 1);
  const auto first = digits(before), last = digits(after);
  if ((!before.empty() && !first) || (!after.empty() && !last) || (!first && !last))
    return RangeVerdict::kWhole;
  if (!first) {  // the last n bytes
    const std::size_t n = std::min<std::uint64_t>(*last, size);
    if (n == 0) return RangeVerdict::kUnsatisfiable;
    range = {size - n, n};
    return RangeVerdict::kPart;
  }
  if (last && *last < *first) return RangeVerdict::kWhole;
  if (*first >= size) return RangeVerdict::kUnsatisfiable;
  const std::uint64_t end = last ? std::min<std::uint64_t>(*last, size - 1) : size - 1;
  range = {static_cast<std::size_t>(*first), static_cast<std::size_t>(end - *first + 1)};
  return RangeVerdict::kPart;
}

}  // namespace

Answered Api::get_fracture(const std::shared_ptr<Request>& request, const Reply& reply) {
  constexpr std::string_view kScheme = "sha256:";
  const std::string& id = request->admission.segment;
  if (id.substr(0, kScheme.size()) == kScheme) {
    const std::string key = id.substr(kScheme.size());
    if (!may_see(*request, key)) return tl::unexpected<Problem>(no_result());
    if (const auto result = service_.find_result(key)) return found_result(*request, result, "result; hit");
    if (const auto result = jobs_.find_result(key)) return found_result(*request, result, "job; hit");
    if (const auto bytes = service_.tiers().expected_bytes(key)) {  // reading blocks: not on this thread
      OrProblem<Terms> terms = terms_of(*request);
      if (!terms) return tl::unexpected<Problem>(std::move(terms.error()));
      const auto overload = dispatcher_.run(expected_reading(*bytes), *terms, [this, request, key, reply] {
        answering(*request, reply, [&]() -> Answered {
          FractureAnswer answer;
          MemoryBudget::Reservation reading(dispatcher_.working());
          if (!service_.fetch_result(key, answer,
                                     [&](std::uint64_t needed) { return reading.grow_to(needed); }))
            return tl::unexpected<Problem>(
                Problem(HttpProblem::kOverloaded, "There is no memory to read this result now.")
                    .with("Retry-After", "2"));
          if (!answer.result) return tl::unexpected<Problem>(no_result());
          return found_result(*request, answer.result, cache_status(answer));
        });
      });
      if (overload) return tl::unexpected<Problem>(to_problem(*overload));
      return std::nullopt;
    }
  }
  return tl::unexpected<Problem>(no_result());
}

Answered Api::found_result(const Request& request, const std::shared_ptr<const FractureResult>& result,
                           std::string_view cache_status) {
  const bool glb = result->format == OutputFormat::kGlb;
  const std::string_view stored = glb ? "model/gltf-binary" : "model/gltf+json";
  const std::string_view offers[] = {stored, "application/json"};
  const auto chosen = negotiate(request.head.field("accept"), std::span(offers).first(glb ? 2 : 1));
  if (!chosen)
    return refuse(HttpProblem::kNotAcceptable,
                  "This result can be had as " + std::string(stored) + (glb ? " or application/json." : "."));
  Response response = result_response(result, *chosen == 1 ? kAsFigures : kAsGlb);
  const std::string etag = response.headers.front().second;
  response.headers.emplace_back("Cache-Status", cache_status);
  response.headers.emplace_back("Cache-Control", std::string(request.payer.account ? "private" : "public") +
                                                     ", max-age=31536000, immutable");
  response.headers.emplace_back("Accept-Ranges", "bytes");
  const std::string none_match = request.head.field("if-none-match");
  if (!none_match.empty() && none_match_fails(none_match, etag)) {
    response.status = 304;
    response.content_type.clear();
    response.body = {};
    return response;
  }
  const std::string if_range = request.head.field("if-range");
  if (request.admission.head_only || (!if_range.empty() && if_range != etag)) return response;
  const std::string size = std::to_string(response.body.size());
  Range range{};
  switch (range_of(request.head.field("range"), response.body.size(), range)) {
    case RangeVerdict::kWhole:
      break;
    case RangeVerdict::kPart:
      response.status = 206;
      response.headers.emplace_back("Content-Range", "bytes " + std::to_string(range.first) + "-" +
                                                         std::to_string(range.first + range.length - 1) +
                                                         "/" + size);
      response.body = response.body.subspan(range.first, range.length);
      break;
    case RangeVerdict::kUnsatisfiable:
      return tl::unexpected<Problem>(
          Problem(HttpProblem::kRangeNotSatisfiable, "The result has " + size + " bytes.")
              .with("Content-Range", "bytes */" + size));
  }
  return response;
}

}  // namespace fracture::http
