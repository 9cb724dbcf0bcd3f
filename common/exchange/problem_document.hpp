// A refusal as servers word it: problem details (RFC 9457), as far as callers use them. No network.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/base/figures.hpp"
#include "common/exchange/exchange.hpp"

namespace fracture::protocol {

/// What is missing, or is no text, is empty.
struct ProblemDocument {
  std::string type{};  ///< "/problems/mesh-not-closed"
  std::string title{}, detail{};
  std::string parameter{};  ///< the one that is concerned (an extension member of this service)
  /// All other members (`errors`, `known`, figures), but for those of the exchange: status, instance, request_id.
  Figures extra{};

  /// The last segment of the type: "mesh-not-closed".
  std::string slug() const;
};

/// Of a document that was read already, also inside of another one. Empty for what is no object.
ProblemDocument problem_in(const nlohmann::json& document);

/// The problem in the body of a response of any media type. If the response has no detail, it is "The server responded with
/// status 404."
ProblemDocument problem_in(const Exchange& exchange);

}  // namespace fracture::protocol
