// Finds the cells that share caps within a solid, and the area of these caps.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/clip/restricted_diagram.hpp"

namespace fracture {

struct CellTouch {
  SiteId cell;
  double area;  ///< m², within the solid
};

class CellTouches {
 public:
  /// The time is nearly linear in the number of caps. Throws Interrupted.
  CellTouches(const RestrictedDiagram& diagram, Pacer& pacer);
  std::span<const CellTouch> of(SiteId s) const {
    return {all_.data() + begin_[s], all_.data() + begin_[s + 1]};
  }

 private:
  std::vector<std::uint32_t> begin_;
  std::vector<CellTouch> all_;
};

}  // namespace fracture
