// Sizes that cannot be meant: a cup of 100 m is one whose file is in millimetres. Nothing is scaled; the report warns and offers
// the likely unit.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "common/base/choice.hpp"
#include "common/base/remarks.hpp"
#include "common/mesh/frame.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// The longest side of an object is at least this, and that of its largest part at most that, m.
inline constexpr double kLeastObject = 1e-3, kMostObject = 100;
/// The longest side of the largest part, as a multiple of the usual size of a material's pieces, is at most this.
inline constexpr double kMostPieces = 1000;

/// Returns the unit that gives an object a usual size, from 1 cm to 12 m, or the one that comes nearest. It is a smaller unit if
/// the object is too large, and a larger one if it is too small. Returns nothing if no unit is better.
/// `longest`: m, if one unit of the file is `metres_per_unit`. `millimetres_first`: if both millimetres and centimetres would do.
std::optional<LengthUnit> likely_unit(double longest, double metres_per_unit, bool millimetres_first);

/// The pieces of a material.
struct UsualPieces {
  std::string_view material;
  double size;  ///< m; 0: unknown
};

/// Warns if the solid's size cannot be meant, and offers the likely unit. If the request states the unit, the size is meant.
/// The first form judges by the size alone. The second one judges by the pieces too, and is silent if the first is not.
void check_size(const Solid& solid, const FrameReport& frame, bool millimetres_first, Remarks& remarks,
                std::vector<Choice>& choices);
void check_size(const Solid& solid, const FrameReport& frame, bool millimetres_first,
                const UsualPieces& pieces, Remarks& remarks, std::vector<Choice>& choices);

}  // namespace fracture
