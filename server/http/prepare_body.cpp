// Prepares the body of a complete request for its handler: checks its digest and decodes its
// Content-Encoding. If this is too much for an io thread, it is done in one step on the pool, in the
// request's class and under its deadline.
#include <algorithm>
#include <stop_token>

#include "server/http/api.hpp"
#include "server/http/content_coding.hpp"
#include "server/http/content_digest.hpp"

namespace fracture::http {
namespace {

/// Assumed ratio of decoded to encoded size if a body does not announce its size, and the growth factor if
/// that is too little.
constexpr std::uint64_t kUsualRatio = 8, kMore = 4;

void release_body(Request& request) {
  std::string().swap(request.body);
  request.pieces.clear();
  request.reservation = {};
}

/// Joins the pieces of the body. Each piece is freed as it is appended, so the body is never in memory twice.
/// Throws Interrupted.
void join_pieces(Request& request, const Execution& execution) {
  if (request.pieces.empty()) return;
  std::string whole;
  whole.reserve(request.body_bytes());
  for (std::string& piece : request.pieces) {  // of kBodyPiece bytes
    execution.poll();
    whole += piece;
    std::string().swap(piece);
  }
  request.pieces.clear();
  whole += request.body;
  request.body = std::move(whole);
}

}  // namespace

Answered Api::on_pool(const ExpectedWork& work, const std::shared_ptr<Request>& request, const Terms& terms,
                      const Reply& reply, Step step) {
  Terms mine = terms;  // even for a job, the client waits for the 202
  mine.priority = std::min(mine.priority, Priority::kBatch);
  std::optional<Error> overload = dispatcher_.run(
      work, mine,
      [this, request, reply, step = std::move(step)](const Execution& execution) mutable {
        answering(*request, reply, [&] { return step(execution); });
      },
      [this, request, reply](Error error) {
        answering(*request, reply, [&]() -> Answered {
          release_body(*request);
          return refusal(with_time(std::move(error), *request), request->id);
        });
      });
  if (overload) return tl::unexpected<Problem>(to_problem(std::move(*overload)));
  return std::nullopt;
}

Answered Api::with_parameters(std::uint64_t bytes, std::uint64_t most,
                              const std::shared_ptr<Request>& request, const Terms& terms, const Reply& reply,
                              std::function<Answered()> go_on) {
  if (request->on_pool || bytes <= most) return go_on();
  return on_pool(expected_reading(bytes), request, terms, reply,
                 [request, go_on = std::move(go_on)](const Execution&) {
                   request->on_pool = true;
                   return go_on();
                 });
}

void Api::start(std::shared_ptr<Request> request, std::stop_token gone, Reply reply) {
  request->received = std::chrono::steady_clock::now();
  if (request->payer.account) {
    request->seat = std::make_shared<tenants::Account::Seat>();
    // Free the seat before the client can send its next request.
    reply = [seat = request->seat, reply = std::move(reply)](Response response) {
      *seat = {};
      reply(std::move(response));
    };
  }
  answering(*request, reply, [&]() -> Answered {
    Preparation preparation;
    preparation.digest = request->head.field("content-digest");
    const OrProblem<ContentCoding> coding = content_coding(request->head.field("content-encoding"));
    const std::uint64_t size = request->body_bytes();
    const bool whole = request->pieces.empty();
    if (coding && size > 0) preparation.coding = *coding;
    if (preparation.coding == ContentCoding::kIdentity) {
      if (whole && (size <= kDigestInline || preparation.digest.empty())) {
        if (!preparation.digest.empty())
          if (auto wrong = check_content_digest(preparation.digest, request->body)) {
            release_body(*request);
            return tl::unexpected<Problem>(std::move(*wrong));
          }
        return dispatch(request, gone, reply);
      }
      preparation.expected = size;
    } else {
      const std::uint64_t announced = whole ? announced_size(request->body, preparation.coding) : 0;
      preparation.expected =
          std::min(std::max(announced > 0 ? announced : kUsualRatio * size, size), limits_.max_decoded_body);
    }
    return prepare_body(request, preparation, gone, reply);
  });
}

Answered Api::prepare_body(const std::shared_ptr<Request>& request, const Preparation& preparation,
                           const std::stop_token& gone, const Reply& reply) {
  OrProblem<Terms> terms = terms_of(*request, gone);
  if (!terms) return tl::unexpected<Problem>(std::move(terms.error()));
  ExpectedWork work = expected_reading(preparation.expected);
  if (!preparation.digest.empty()) work.seconds += expected_reading(request->body_bytes()).seconds;
  if (preparation.coding != ContentCoding::kIdentity)
    work.seconds += expected_decoding(preparation.expected).seconds;
  return on_pool(work, request, *terms, reply,
                 [this, request, preparation, gone, reply](const Execution& execution) {
                   return prepared_body(request, preparation, execution, gone, reply);
                 });
}

Answered Api::prepared_body(const std::shared_ptr<Request>& request, const Preparation& preparation,
                            const Execution& execution, const std::stop_token& gone, const Reply& reply) {
  // If the route takes less than a mesh, its limit applies to the encoded and the decoded body.
  const std::uint64_t limit =
      request->admission.max_body < limits_.max_body ? request->admission.max_body : limits_.max_decoded_body;
  const auto refused = [&](Problem problem) {
    release_body(*request);
    return tl::unexpected<Problem>(std::move(problem));
  };
  try {
    execution.poll();  // the wait for this turn may have been long
    join_pieces(*request, execution);
    if (!preparation.digest.empty())
      if (auto wrong = check_content_digest(preparation.digest, request->body, execution))
        return refused(std::move(*wrong));
    Decoding decoding = decode_body(request->body, preparation.coding, limit, request->reservation, execution,
                                    preparation.expected);
    if (decoding.larger) {
      Preparation more = preparation;
      more.digest.clear();
      more.expected *= kMore;
      return prepare_body(request, more, gone, reply);
    }
    if (decoding.no_room) return refused(no_memory(request->reservation));
    if (decoding.problem) return refused(std::move(*decoding.problem));
  } catch (const Interrupted& interrupted) {
    return refused(to_problem(to_error(interrupted)));
  }
  request->on_pool = true;
  return dispatch(request, gone, reply);
}

}  // namespace fracture::http
