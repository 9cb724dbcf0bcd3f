// The parts that are near enough to a part to be in contact with it.
#pragma once

#include <array>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"
#include "common/bvh/box_tree.hpp"
#include "common/solid/solid.hpp"

namespace fracture::contacts_detail {

/// A tree of the parts' boxes. The boxes are aligned with the axes, or with the directions in which most of
/// the surface faces if that makes them smaller. For example, rotated boards next to each other have
/// axis-aligned boxes that all meet.
class PartBoxes {
 public:
  /// Borrows the solid. `reach`: m, more than rounding. Throws Interrupted.
  PartBoxes(const Solid& solid, double reach, const Execution& execution);

  /// Calls visit(other) for each other part whose boxes are within reach.
  template <class Visit>
  void each_near(std::uint32_t part, Pacer& pacer, const Visit& visit) const {
    const Box own = widened(solid_.parts[part].box);
    const auto meets = [&](std::uint32_t other) { return own.intersects(solid_.parts[other].box); };
    tree_.each_overlapping(turned_.empty() ? own : widened(turned_[part]), [&](std::uint32_t other) {
      pacer.step();
      if (other != part && meets(other)) visit(other);
    });
  }

 private:
  Box widened(const Box& box) const {
    return {box.min - Vec3d{reach_, reach_, reach_}, box.max + Vec3d{reach_, reach_, reach_}};
  }

  const Solid& solid_;
  const double reach_;
  std::vector<Box> turned_;  ///< per part; empty if the tree contains axis-aligned boxes
  BoxTree tree_;
};

}  // namespace fracture::contacts_detail
