// A finished answer, as the caches and the responses share it.
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

/// Immutable and shared: by the caches and by every response that is being written from it.
struct FractureResult {
  std::string key;          ///< RequestKeys::result
  std::string mesh_digest;  ///< "sha256:<hex>", digest_of(the request)
  OutputFormat format = OutputFormat::kGlb;
  std::vector<std::uint8_t> file;
  Digest file_digest;                      ///< SHA-256 of `file`
  TextRange figures;                       ///< in `file`: the extras.fracture object of the root node
  Digest figures_digest;                   ///< SHA-256 of that object's text
  std::string parameters{};                ///< canonical, as JSON text; empty: of a variant
  std::optional<AnswerSummary> summary{};  ///< where it was made by this process

  std::span<const std::uint8_t> bytes_of(TextRange range) const {
    return std::span(file).subspan(range.at, range.size);
  }
};

enum class CacheOutcome {
  kNotConsulted,
  kHit,
  kMissStored,
  kMissNotStored,
  kCollapsed,  ///< not there, but somebody else was computing it: waited for that
};

}  // namespace fracture
