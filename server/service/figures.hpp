// The summary of a finished answer. If this process made the answer, the summary comes from its data; otherwise it is read
// from the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "common/base/json_reader.hpp"
#include "common/base/remarks.hpp"
#include "common/fragment/fragments.hpp"
#include "common/mesh/dropped.hpp"
#include "server/service/engine.hpp"

namespace fracture {

/// Limits on the JSON of an answer. JSON that exceeds them was not written by any server of ours.
inline constexpr JsonLimits kOfAnAnswer{.depth = 64, .bytes = std::size_t{1} << 30};

struct AnswerSummary {
  Certificate certificate;
  bool partition = true;  ///< fragments are a partition; false: only closed (dual=barycenter)
  bool judged = true;     ///< false: the server that made it did not count caps without a mirror image
  Remarks remarks;
  std::vector<Dropped> dropped{};  ///< what the source contains and the answer does not
};

AnswerSummary summary_of(const FracturedSolid& fractured);

/// Returns where the root node's `extras.fracture` object is in a file that some server made. Skims the text up to there
/// without parsing it. Returns nothing if there is no such object; the bytes may be arbitrary.
std::optional<TextRange> figures_in(std::span<const std::uint8_t> file, OutputFormat format);

/// Reads the summary from such a file. Throws InternalError if it has no such object, or if the object has no certificate.
AnswerSummary summary_in(std::span<const std::uint8_t> file, OutputFormat format);

}  // namespace fracture
