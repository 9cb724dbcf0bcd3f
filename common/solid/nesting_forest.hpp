// Which shell lies in which, where no two of them touch.
#pragma once

#include <optional>
#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/shells.hpp"
#include "common/solid/surface.hpp"
#include "common/solid/winding.hpp"

namespace fracture::solid_detail {

/// Shells that do not touch one another wind around all points of another shell alike, so those around a
/// shell are its innermost one, `up`, those around that, and so on.
struct NestingForest {
  std::vector<std::uint32_t> up;  ///< per shell; kNoIndex where nothing winds around it, and for flat ones
  std::vector<int> number;        ///< how often `up` winds around it, as the file orients both
};

/// The forest of the shells that are not flat. Nothing where two of them touch or cross, or where that cannot
/// be told at a cost near-linear in the triangles.
///
/// A ray along +x from the vertex of largest x of a shell first meets a shell that reaches further: what
/// winds around that one winds around this one. So one search for the nearest triangle per shell is enough,
/// however deep they are nested.
std::optional<NestingForest> find_nesting_forest(const Surface& surface, const Shells& shells,
                                                 WindingNumbers& windings, const Execution& execution);

}  // namespace fracture::solid_detail
