// Results as resources: GET and HEAD /fractures/{id}. Also sends the results of all other requests.
#include <spdlog/spdlog.h>
#include <algorithm>
#include <charconv>
#include <memory>
#include <stop_token>

#include "common/base/printable.hpp"
#include "server/http/accept.hpp"
#include "server/http/api.hpp"
#include "server/http/result_response.hpp"

namespace fracture::http {
namespace {

/// `id`: as the request gave it.
Problem no_result(std::string_view id) {
  if (!digest_in(id))
    return Problem(HttpProblem::kNotFound,
                   "The id of a result is sha256: followed by 64 lower-case hex digits; it was '" +
                       shortened(printable(id)) + "'.");
  return Problem(
      HttpProblem::kNotFound,
      "This result is not in the cache, or has been removed from it. Send the same fracture request again to recompute it.");
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

/// Parses one range of bytes (RFC 9110, section 14.2). Several ranges, other units and malformed fields are
/// answered with the whole representation, as that section allows.
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

/// Returns the requested part of the response.
Answered ranged(const RequestHead& head, bool head_only, Response response) {
  const std::string if_range = head.field("if-range");
  const std::string_view etag = response.header("ETag");
  const auto is_coded = [](const auto& field) { return field.first == "Content-Encoding"; };
  if (head_only || (!if_range.empty() && if_range != etag) ||
      std::any_of(response.headers.begin(), response.headers.end(), is_coded))
    return response;
  const std::string size = std::to_string(response.body.size());
  Range range{};
  switch (range_of(head.field("range"), response.body.size(), range)) {
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

}  // namespace

Answered Api::get_fracture(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                           const Reply& reply) {
  // Only digests name results: the cache also holds data derived from results, under other names.
  const std::optional<std::string> named = digest_in(request->admission.segment);
  const auto missing = [this, request, named](bool nowhere) -> Answered {
    std::optional<Problem> lost = named ? lost_result(*request, *named, nowhere) : std::nullopt;
    return tl::unexpected<Problem>(lost ? std::move(*lost) : no_result(request->admission.segment));
  };
  if (!named || !may_see(*request, *named)) return missing(false);
  const std::string& key = *named;
  if (const auto result = service_.find_result(key))
    return found_result(request, result, "result; hit", reply);
  if (const auto result = jobs_.find_result(key)) return found_result(request, result, "job; hit", reply);
  const auto bytes = service_.tiers().expected_bytes(key);
  if (!bytes) return missing(true);
  // Reading blocks, so it must not run on this thread.
  OrProblem<Terms> terms = terms_of(*request, gone);
  if (!terms) return tl::unexpected<Problem>(std::move(terms.error()));
  const auto read = [this, request, key, reply, missing,
                     client = terms->payer.flow.name](const Execution& execution) -> Answered {
    FractureAnswer answer;
    MemoryBudget::Reservation reading(dispatcher_.working());
    if (!service_.fetch_result(
            key, answer, [&](std::uint64_t needed) { return reading.grow_to(needed); }, execution, client))
      return tl::unexpected<Problem>(
          Problem(ErrorCode::kOverloaded,
                  "The server does not have enough memory to read this result at the moment.")
              .with("Retry-After", "2"));
    // Redis may only be unreachable, so only the disk can show that the result is lost.
    if (!answer.result) return missing(answer.redis_cache == CacheOutcome::kNotConsulted);
    reading = {};  // from here on, the result is counted as an answer
    return found_result(request, answer.result, cache_status(answer), reply);
  };
  return on_pool(expected_reading(*bytes), request, *terms, reply, read);
}

Answered Api::send_result(const std::shared_ptr<Request>& request,
                          std::shared_ptr<const FractureResult> result, const Representation& representation,
                          const Terms& terms, const Reply& reply, Finish finish, bool is_computed) {
  if (representation.coding == ContentCoding::kIdentity)
    return finish(result_response(result, representation, nullptr));
  const std::string key = variant_key(*result, representation);
  auto variant = service_.find_result(key);
  if (variant || request->admission.head_only)
    return finish(result_response(result, representation, variant));
  // The result is held while it waits to be compressed. Caches may evict it in the meantime.
  const auto held = std::make_shared<HeldBuffers::Hold>();
  if (auto refusal = hold_answer(request->address, result.get(), memory_size(*result), *held))
    return tl::unexpected<Problem>(std::move(*refusal));
  Compressions::Wanted wanted;
  wanted.key = key;
  wanted.work = expected_coding(plain_bytes(*result, representation.figures).size());
  wanted.terms = terms;
  // Jobs are in the background class, but here the result exists and a client waits for it.
  wanted.terms.priority = std::min(terms.priority, Priority::kBatch);
  wanted.terms.is_computed = is_computed;
  // A job's deadline applies only to its computation, so it is not used here.
  wanted.longest = limits_.deadline;
  wanted.make = [this, result, representation](const Execution& execution) {
    auto made = make_variant(*result, representation, execution);
    try {
      service_.keep_variant(made);
    } catch (const std::exception& e) {
      spdlog::warn("keeping a compressed answer failed: {}", e.what());
    }
    return made;
  };
  wanted.reply = [this, request, result, representation, reply, finish,
                  held](const Expected<Compressions::Made>& made) {
    *held = HeldBuffers::Hold();  // the session counts what is sent
    answering(*request, reply, [&]() -> Answered {
      if (made) return finish(result_response(result, representation, *made));
      // The uncompressed answer is still available.
      if (const auto plain = as_it_is(request->head, *result, representation.figures))
        return finish(result_response(result, *plain, nullptr));
      return tl::unexpected<Problem>(
          Problem(ErrorCode::kOverloaded, made.error().detail).with("Retry-After", "2"));
    });
  };
  compressions_.obtain(std::move(wanted));
  return std::nullopt;
}

Answered Api::found_result(const std::shared_ptr<Request>& request,
                           const std::shared_ptr<const FractureResult>& result, std::string_view cache_status,
                           const Reply& reply) {
  const bool glb = result->format == OutputFormat::kGlb;
  const std::string_view stored = glb ? "model/gltf-binary" : "model/gltf+json";
  const std::string_view offers[] = {stored, "application/json"};
  const auto chosen = negotiate(request->head.field("accept"), std::span(offers).first(glb ? 2 : 1));
  if (!chosen)
    return refuse(HttpProblem::kNotAcceptable, "This result is available as " + std::string(stored) +
                                                   (glb ? " or application/json." : "."));
  const OrProblem<Representation> representation = represent(request->head, *result, *chosen == 1);
  if (!representation) return tl::unexpected<Problem>(representation.error());
  const auto describe = [status = std::string(cache_status),
                         whose = request->payer.account ? "private" : "public"](Response& response) {
    response.headers.emplace_back("Cache-Status", status);
    response.headers.emplace_back("Cache-Control", std::string(whose) + ", max-age=31536000, immutable");
    response.headers.emplace_back("Accept-Ranges", "bytes");
  };
  const std::string match = request->head.field("if-match");
  if (!match.empty() && !names_etag(match, representation->etag, Comparison::kStrong))
    return refuse(HttpProblem::kPreconditionFailed,
                  "The current ETag is " + representation->etag + ", which If-Match does not list.");
  const std::string none_match = request->head.field("if-none-match");
  if (!none_match.empty() && names_etag(none_match, representation->etag, Comparison::kWeak)) {
    Response response = result_response(result, *representation, nullptr);
    describe(response);
    response.status = 304;
    response.content_type.clear();
    response.body = {};
    return response;
  }
  const OrProblem<Terms> terms = terms_of(*request);
  if (!terms) return tl::unexpected<Problem>(terms.error());
  return send_result(request, result, *representation, *terms, reply,
                     [request, describe](Response response) -> Answered {
                       describe(response);
                       return ranged(request->head, request->admission.head_only, std::move(response));
                     });
}

}  // namespace fracture::http
