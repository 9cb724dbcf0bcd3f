// The meaning of an exchange for its request.
#pragma once

#include <optional>

#include "client/protocol/client.hpp"
#include "common/base/error.hpp"
#include "common/exchange/exchange.hpp"

namespace fracture::protocol {

/// The exchange's outcome as the failure of its request, if it is not retried.
Failure failure_of(Exchange::Outcome outcome);

/// Takes the texts of the problem document, if the body is one.
void read_problem(const Exchange& exchange, Answer& answer);

/// Returns kDamagedAnswer if the answer is not of the requested kind: not JSON, or bytes that do not match their Repr-Digest.
std::optional<Error> damage(RequestKind kind, const Exchange& exchange);

}  // namespace fracture::protocol
