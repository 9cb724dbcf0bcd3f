#include "client/protocol/outcomes.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "common/exchange/headers.hpp"
#include "common/exchange/problem_document.hpp"

namespace fracture::protocol {
namespace {

bool is_json(const std::string& body) { return nlohmann::json::accept(body); }

}  // namespace

Failure failure_of(Exchange::Outcome outcome) {
  using Outcome = Exchange::Outcome;
  switch (outcome) {
    case Outcome::kAnswered:
      return Failure::kNone;
    case Outcome::kNoServer:
    case Outcome::kBroken:
      return Failure::kServerAbsent;
    case Outcome::kTimedOut:
      return Failure::kTimedOut;
    case Outcome::kTooLarge:
      return Failure::kTooLarge;
    case Outcome::kInterrupted:
      return Failure::kCancelled;
  }
  return Failure::kCancelled;
}

void read_problem(const Exchange& exchange, Answer& answer) {
  ProblemDocument problem = problem_in(exchange);
  answer.problem = problem.slug();
  answer.detail = std::move(problem.detail);
}

std::optional<Error> damage(RequestKind kind, const Exchange& exchange) {
  const auto damaged = [](const char* how) { return Error{ErrorCode::kDamagedAnswer, how}; };
  if (kind != RequestKind::kFracture && !is_json(exchange.body)) return damaged("The response is not JSON.");
  if (kind != RequestKind::kFracture) return std::nullopt;
  if (exchange.repr_digest.empty()) return damaged("The answer has no Repr-Digest, so it cannot be checked.");
  if (!digest_matches(exchange.repr_digest, exchange.body))
    return damaged("The bytes of the answer do not match its Repr-Digest: they were changed in transit.");
  return std::nullopt;
}

}  // namespace fracture::protocol
