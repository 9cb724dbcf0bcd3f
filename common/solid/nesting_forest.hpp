// Finds which shell is inside which, if no two of them touch.
#pragma once

#include <optional>
#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/shells.hpp"
#include "common/solid/surface.hpp"
#include "common/solid/winding.hpp"

namespace fracture::solid_detail {

/// If shells do not touch, each shell winds equally around all points of another shell. So the shells around
/// a shell are its innermost one, `up`, the innermost one around that, and so on.
struct NestingForest {
  std::vector<std::uint32_t> up;  ///< per shell; kNoIndex if nothing winds around it, or if it is flat
  std::vector<int> number;        ///< winding number of `up` around it, with the orientations in the file
};

/// The forest of the shells that are not flat. None if two of them touch or cross, or if that cannot be
/// decided at a cost near-linear in the triangles.
///
/// A ray along +x from a shell's vertex of largest x first meets a shell that extends farther. Every shell
/// that winds around that one also winds around this one. So one search per shell for the nearest triangle is
/// enough, however deep the nesting is.
std::optional<NestingForest> find_nesting_forest(const Surface& surface, const Shells& shells,
                                                 WindingNumbers& windings, const Execution& execution);

}  // namespace fracture::solid_detail
