// What a finished answer comes to: typed where it was made, and read from the file where that is from elsewhere.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "common/base/json_reader.hpp"
#include "common/base/remarks.hpp"
#include "common/fragment/fragments.hpp"
#include "server/service/engine.hpp"

namespace fracture {

/// What nests deeper or holds more than this is no answer of ours.
inline constexpr JsonLimits kOfAnAnswer{.depth = 64, .bytes = std::size_t{1} << 30};

struct AnswerSummary {
  Certificate certificate;
  bool partition = true;  ///< is promised; else that each fragment is closed, no more (dual=barycenter)
  bool judged = true;     ///< false: by a server that did not count caps without a mirror image
  Remarks remarks;
};

AnswerSummary summary_of(const FracturedSolid& fractured);

/// The root node's `extras.fracture` object in a file that some server made. Skims the text up to there
/// without parsing it; nothing where it has none, whatever the bytes are.
std::optional<TextRange> figures_in(std::span<const std::uint8_t> file, OutputFormat format);

/// Of such a file. Throws InternalError where it has no such object, or none with a certificate.
AnswerSummary summary_in(std::span<const std::uint8_t> file, OutputFormat format);

}  // namespace fracture
