// Which shell is a part, which a cavity, and of what.
#pragma once

#include "common/base/execution.hpp"
#include "common/solid/shells.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

struct Nesting {
  std::vector<std::uint8_t> reversed;    ///< per shell: inside out, its triangles have to be flipped
  std::vector<std::uint32_t> cavity_of;  ///< per shell: the outward shell it is a cavity of, or kNoIndex
};

/// An inward shell (negative volume) is a cavity where the other shells wind around it at least once: of the
/// smallest outward shell that winds around it. An inward shell around which nothing winds is inside out. If
/// all outermost shells are inward, the whole file is inside out and every shell is reversed first. An
/// outward shell inside another is a part of its own (the parts overlap). Winding numbers come from one ray
/// for each inward shell, and for outward ones until one is found that nothing encloses (winding.hpp); where
/// very many are nested in one another, from the forest that they are (nesting_forest.hpp). Nothing is
/// computed when no shell is inward.
Nesting nest_shells(const Surface& surface, const Shells& shells, const Execution& execution);

}  // namespace fracture::solid_detail
