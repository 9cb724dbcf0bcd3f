// POST /fracture: receives a mesh and parameters, and returns fragments.
#include "server/http/api.hpp"
#include "server/http/mesh_input.hpp"
#include "server/http/multipart.hpp"
#include "server/http/parameter_weight.hpp"
#include "server/http/prefer.hpp"
#include "server/http/result_response.hpp"

namespace fracture::http {
Answered Api::with_mesh_input(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                              const Reply& reply, WithMesh go_on) {
  OrProblem<Terms> terms = terms_of(*request, gone);
  if (!terms) return tl::unexpected<Problem>(std::move(terms.error()));
  auto body = std::make_shared<Body>(Body{std::move(request->body), std::move(request->reservation)});
  const std::size_t size = body->bytes.size();
  // Called once. It hands the body over to the continuation, so that the body is freed as soon as it is no
  // longer needed.
  auto read = [this, request, body = std::move(body), terms = *terms,
               go_on = std::move(go_on)]() mutable -> Answered {
    std::shared_ptr<Body> own = std::move(body);
    Execution here;
    here.stop = terms.gone;
    here.turn = WorkerPool::turn();
    if (terms.deadline != std::chrono::steady_clock::time_point::max()) here.deadline = terms.deadline;
    OrProblem<FractureRequest> input = read_mesh_input(
        *request, own, service_, here, [&](const std::string& key) { return may_see(*request, key); });
    if (!input) return tl::unexpected<Problem>(std::move(input.error()));
    input->digest = digest_of(*input, here).hex();
    return go_on(std::move(*input), std::move(own), terms);
  };
  // A form also contains parameters, of any size.
  const bool form = media_type_of(request->head.field("content-type")) == "multipart/form-data";
  const std::vector<RawParameter> given = raw_parameters(request->admission.query);
  const bool few = parse_weight(request->head.query.size(), given, service_.parameters()) <= kParseInline &&
                   service_.earlier_bytes(given) <= kEarlierInline;
  if (request->on_pool || (!form && size <= kReadInline && few)) return read();
  return on_pool(expected_reading(size), request, *terms, reply,
                 [read = std::move(read)](const Execution&) mutable { return read(); });
}

Answered Api::post_fracture(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                            const Reply& reply) {
  if (media_type_of(request->head.field("content-type")) == "application/json")
    return fracture_stored(request, request->body, "", gone, reply);
  return with_mesh_input(
      request, gone, reply,
      [this, request, reply](FractureRequest input, std::shared_ptr<Body> body, const Terms& terms) {
        body.reset();
        return fracture(request, std::move(input), terms, reply);
      });
}

Answered Api::fracture(const std::shared_ptr<Request>& request, FractureRequest asked, Terms terms,
                       const Reply& reply) {
  enter_in_ledger(*request, terms);
  const std::size_t offered = request->admission.representation;
  asked.output = offered == kAsGltf ? OutputFormat::kGltf : OutputFormat::kGlb;
  if (preferences_of(request->head).respond_async) {
    // The job takes over the request's seat, which would otherwise be freed with the answer.
    if (terms.seat) terms.seat = std::make_shared<tenants::Account::Seat>(std::move(*terms.seat));
    return start_job(request, std::move(asked), terms, reply);
  }
  std::optional<Error> overload = dispatcher_.fracture(
      std::move(asked), terms, [this, request, terms, reply](Expected<FractureAnswer> answer) {
        answering(*request, reply, [&]() -> Answered {
          if (!answer) return refusal(with_time(std::move(answer.error()), *request), request->id);
          return answer_fracture(request, *answer, terms, reply);
        });
      });
  if (overload) return tl::unexpected<Problem>(to_problem(std::move(*overload)));
  return std::nullopt;
}

Answered Api::answer_fracture(const std::shared_ptr<Request>& request, const FractureAnswer& answer,
                              const Terms& terms, const Reply& reply, const std::string& applied) {
  const bool figures = request->admission.representation == kAsFigures;
  const auto representation = represent(request->head, *answer.result, figures);
  if (!representation) return tl::unexpected<Problem>(representation.error());
  return send_result(
      request, answer.result, *representation, terms, reply,
      [status = cache_status(answer), timing = server_timing(answer), applied,
       queued = answer.queue_milliseconds,
       is_private = request->payer.account != nullptr](Response response) -> Answered {
        response.headers.emplace_back("Cache-Status", status);
        response.headers.emplace_back("Server-Timing", timing);
        if (is_private) response.headers.emplace_back("Cache-Control", "private");
        if (!applied.empty()) response.headers.emplace_back("Preference-Applied", applied);
        response.queue_milliseconds = queued;
        return response;
      },
      answer.result_cache != CacheOutcome::kHit);
}

}  // namespace fracture::http
