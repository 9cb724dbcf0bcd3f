// Problem details that servers send (RFC 9457), as far as callers use them. No network.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/base/figures.hpp"
#include "common/exchange/exchange.hpp"

namespace fracture::protocol {

/// Members that are missing or not text are empty.
struct ProblemDocument {
  std::string type{};  ///< "/problems/mesh-not-closed"
  std::string title{}, detail{};
  std::string parameter{};  ///< the parameter concerned (an extension member of this service)
  /// All other members (`errors`, `known`, numbers), except those about the exchange: status, instance,
  /// request_id.
  Figures extra{};

  /// The last segment of the type: "mesh-not-closed".
  std::string slug() const;
};

/// Reads a problem from a parsed document, possibly a part of another one. Empty if it is not an object.
ProblemDocument problem_in(const nlohmann::json& document);

/// Reads the problem in the body of a response with any media type. If it has no detail, uses "The server
/// responded with status 404."
ProblemDocument problem_in(const Exchange& exchange);

}  // namespace fracture::protocol
