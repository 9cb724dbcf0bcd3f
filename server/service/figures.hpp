// Where the figures of an answer stand in its file: found once, when it is encoded, and kept beside it, so
// that nobody parses the file to give them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "server/service/engine.hpp"

namespace fracture {

struct FractureResult;

/// Bytes of a file; none where `size` is 0.
struct TextRange {
  std::uint64_t at = 0, size = 0;
};

/// The root node's `extras.fracture` object in a file that this service made. Skims the text up to there
/// without parsing it; nothing where it has none, whatever the bytes are.
std::optional<TextRange> figures_in(std::span<const std::uint8_t> file, OutputFormat format);

/// The value of a member of the object that stands there.
std::optional<TextRange> member_of(std::span<const std::uint8_t> file, TextRange object,
                                   std::string_view name);

/// Fills in `figures`, `figures_digest` and `parameters` from the file.
void locate_figures(FractureResult& result);

}  // namespace fracture
