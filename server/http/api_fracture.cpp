// POST /fracture: a mesh and parameters in, fragments out.
#include "server/http/api.hpp"
#include "server/http/mesh_input.hpp"
#include "server/http/multipart.hpp"
#include "server/http/result_response.hpp"

namespace fracture::http {
namespace {

/// Bodies up to this size are taken apart and hashed on the io thread: 0.15 ms with the SHA instructions of
/// current processors, less than the way to another thread and back costs under load.
constexpr std::size_t kReadInline = 256u << 10;

}  // namespace

Answered Api::with_mesh_input(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                              const Reply& reply, WithMesh go_on) {
  OrProblem<Terms> terms = terms_of(*request);
  if (!terms) return tl::unexpected<Problem>(std::move(terms.error()));
  terms->gone = gone;
  const auto body = std::make_shared<Body>(Body{std::move(request->body), std::move(request->reservation)});
  const auto read = [this, request, body, terms = *terms, go_on = std::move(go_on)]() -> Answered {
    OrProblem<FractureRequest> input = read_mesh_input(
        *request, body, service_, [&](const std::string& key) { return may_see(*request, key); });
    if (!input) return tl::unexpected<Problem>(std::move(input.error()));
    return go_on(std::move(*input), body, terms);
  };
  if (body->bytes.size() <= kReadInline) return read();
  const auto overload = dispatcher_.run(expected_reading(body->bytes.size()), *terms,
                                        [this, request, read, reply] { answering(*request, reply, read); });
  if (overload) return tl::unexpected<Problem>(to_problem(*overload));
  return std::nullopt;
}

Answered Api::post_fracture(const std::shared_ptr<Request>& request, const std::stop_token& gone,
                            const Reply& reply) {
  if (media_type_of(request->head.field("content-type")) == "application/json")
    return fracture_stored(request, request->body, "", gone, reply);
  return with_mesh_input(
      request, gone, reply,
      [this, request, reply](FractureRequest input, const std::shared_ptr<Body>&, const Terms& terms) {
        return fracture(request, std::move(input), terms, reply);
      });
}

Answered Api::fracture(const std::shared_ptr<Request>& request, FractureRequest asked, Terms terms,
                       const Reply& reply) {
  enter_in_ledger(*request, terms);
  const std::size_t representation = request->admission.representation;
  asked.output = representation == kAsGltf ? OutputFormat::kGltf : OutputFormat::kGlb;
  if (prefers_async(request->head)) return start_job(*request, std::move(asked), terms);
  const std::optional<Overload> overload = dispatcher_.fracture(
      std::move(asked), terms, [this, request, representation, reply](Expected<FractureAnswer> answer) {
        answering(*request, reply, [&]() -> Answered {
          if (!answer) return refusal(std::move(answer.error()), request->id);
          Response response = result_response(answer->result, representation);
          response.headers.emplace_back("Cache-Status", cache_status(*answer));
          response.headers.emplace_back("Server-Timing", server_timing(*answer));
          if (request->payer.account) response.headers.emplace_back("Cache-Control", "private");
          response.queue_milliseconds = answer->queue_milliseconds;
          return response;
        });
      });
  if (overload) return tl::unexpected<Problem>(to_problem(*overload));
  return std::nullopt;
}

}  // namespace fracture::http
