// A finished answer, which caches and responses share.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/digest/digest.hpp"
#include "server/service/engine.hpp"
#include "server/service/figures.hpp"

namespace fracture {

/// Immutable. Shared by the caches and by all responses that are being written from it.
struct FractureResult {
  std::string key;          ///< RequestKeys::result
  std::string mesh_digest;  ///< "sha256:<hex>", digest_of(the request)
  OutputFormat format = OutputFormat::kGlb;
  std::vector<std::uint8_t> file;
  Digest file_digest;                      ///< SHA-256 of `file`
  TextRange figures;                       ///< range of the root node's extras.fracture object in `file`
  Digest figures_digest;                   ///< SHA-256 of that object's text
  std::string parameters{};                ///< canonical parameters as JSON text; empty in a variant
  std::optional<AnswerSummary> summary{};  ///< only if this process made the answer

  std::span<const std::uint8_t> bytes_of(TextRange range) const {
    return std::span(file).subspan(range.at, range.size);
  }
};

enum class CacheOutcome {
  kNotConsulted,
  kHit,
  kMissStored,
  kMissNotStored,
  kCollapsed,  ///< a miss, but another request was already computing the value: this one waited for it
};

}  // namespace fracture
