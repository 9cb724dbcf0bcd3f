// The triangles of each part of a pair that are near the other part.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"
#include "common/base/vec.hpp"
#include "common/bvh/box_tree.hpp"
#include "common/solid/solid.hpp"

namespace fracture::contacts_detail {

using Corners = std::array<Vec3d, 3>;

/// A piece of surface: its area, m², and the integral of the position over it, m³.
struct Patch {
  double area = 0;
  Vec3d moment;
  void add(double more, const Vec3d& more_moment) {
    area += more;
    moment = moment + more_moment;
  }
};

/// A triangle in coordinates relative to the middle of a pair of parts, which avoids cancellation far from
/// the origin.
struct NearTriangle {
  Corners corners;
  Vec3d normal;  ///< unit, outwards; 0 for a triangle without area
  double area;
  Box box;
  std::uint32_t triangle;  ///< in the solid
  Patch faced;             ///< facing.hpp
};

/// The surfaces of all parts, searchable by box. Borrows the solid.
class PartSurfaces {
 public:
  PartSurfaces(const Solid& solid, const Execution& execution);

  const Solid& solid() const { return solid_; }
  std::uint32_t triangles_of(std::uint32_t part) const { return begin_[part + 1] - begin_[part]; }
  std::uint32_t first_of(std::uint32_t part) const { return begin_[part]; }
  Corners corners(std::uint32_t triangle) const {
    const auto& v = solid_.triangles[triangle];
    return {to_double(solid_.positions[v[0]]), to_double(solid_.positions[v[1]]),
            to_double(solid_.positions[v[2]])};
  }

  /// Calls visit(triangle) for each triangle of the part whose box meets this box, and possibly for a few
  /// others.
  template <class Visit>
  void each_near(std::uint32_t part, const Box& box, Pacer& pacer, const Visit& visit) const {
    if (const BoxTree* tree = trees_[part].get()) {
      tree->each_overlapping(box, [&](std::uint32_t k) {
        pacer.step();
        visit(begin_[part] + k);
      });
      return;
    }
    for (std::uint32_t t = begin_[part]; t < begin_[part + 1]; ++t)
      if (bounds_of(t).intersects(box)) visit(t);
    pacer.step(triangles_of(part));
  }

  /// A part's surface, seen from the middle of the part's box.
  struct Core {
    Vec3d center;
    double farthest = 0;  ///< m: largest distance of a vertex from the centre
    double nearest = 0;   ///< m: smallest distance of the surface from the centre
    int winding = 0;      ///< the part's winding number around all points nearer to the centre than `nearest`
  };
  /// Returns the core, which is computed on first use; thread-safe. Throws Interrupted.
  const Core& core(std::uint32_t part, Pacer& pacer) const;

  /// Whether a search costs less than examining all triangles of the part.
  bool has_tree(std::uint32_t part) const { return trees_[part] != nullptr; }

 private:
  static constexpr std::uint32_t kSmallPart = 64;  ///< up to this number, triangles are examined one by one

  Box bounds_of(std::uint32_t triangle) const;

  const Solid& solid_;
  std::vector<std::uint32_t> begin_;             ///< per part, plus the end
  std::vector<std::unique_ptr<BoxTree>> trees_;  ///< for parts that are not small
  struct LazyCore {
    std::once_flag once;
    Core core;
  };
  mutable std::vector<LazyCore> cores_;  ///< per part
};

inline bool contains(const Box& outer, const Box& inner) {
  for (int axis = 0; axis < 3; ++axis)
    if (inner.min[axis] < outer.min[axis] || inner.max[axis] > outer.max[axis]) return false;
  return true;
}
inline Box widened(const Box& box, double by) {
  return {box.min - Vec3d{by, by, by}, box.max + Vec3d{by, by, by}};
}

/// Two parts, and the triangles of each that are near the other. An object is reused for many pairs. Throws Interrupted.
struct NearPair {
  std::uint32_t part_a = 0, part_b = 0;
  Vec3d origin;
  double rounding = 0;  ///< m: smaller distances are noise
  double reach = 0;     ///< m: the gap and the rounding
  std::vector<NearTriangle> a, b;
  std::vector<std::array<std::uint32_t, 2>> pairs;  ///< indices into a and b: all within reach, and others
  bool whole = false;  ///< a and b contain all triangles that meet the other part's box, widened by reach

  /// Finds all pairs and at least the triangles in them; for a part with a tree, only these triangles.
  void gather(const PartSurfaces& surfaces, const Execution& execution, Pacer& pacer);
  void gather_whole(const PartSurfaces& surfaces, const Execution& execution, Pacer& pacer);

 private:
  void gather_near(const PartSurfaces& surfaces, std::uint32_t part, std::uint32_t other,
                   std::vector<NearTriangle>& near, Pacer& pacer) const;
  /// Fills `found` with the triangles of the searched part near the others, and `pairs`.
  void search(const PartSurfaces& surfaces, std::uint32_t searched, std::vector<NearTriangle>& found,
              const std::vector<NearTriangle>& others, Pacer& pacer);
  NearTriangle made_of(const PartSurfaces& surfaces, std::uint32_t triangle) const;
  void find_pairs(const Execution& execution, Pacer& pacer);
};

}  // namespace fracture::contacts_detail
