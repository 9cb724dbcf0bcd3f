// Decides which shells are parts, which are cavities, and of which part.
#pragma once

#include "common/base/execution.hpp"
#include "common/solid/shells.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

struct Nesting {
  std::vector<std::uint8_t> reversed;    ///< per shell: it is inside out and its triangles must be flipped
  std::vector<std::uint32_t> cavity_of;  ///< per shell: the outward shell that it is a cavity of, or kNoIndex
};

/// An inward shell (negative volume) is a cavity if the other shells wind around it at least once. It belongs
/// to the smallest outward shell that winds around it. An inward shell that nothing winds around is inside
/// out. If all outermost shells are inward, the whole file is inside out, and every shell is reversed first.
/// An outward shell inside another is a separate part (the parts overlap).
///
/// Winding numbers come from one ray for each inward shell, and for outward shells until one is found that
/// nothing encloses (winding.hpp). If very many shells are nested, they come from the forest of shells
/// (nesting_forest.hpp). If no shell is inward, nothing is computed.
Nesting nest_shells(const Surface& surface, const Shells& shells, const Execution& execution);

}  // namespace fracture::solid_detail
