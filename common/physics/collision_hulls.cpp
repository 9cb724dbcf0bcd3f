#include "common/physics/collision_hulls.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "common/base/scratch.hpp"
#include "common/physics/divided_hulls.hpp"
#include "common/physics/hull_maker.hpp"

namespace fracture {
namespace {

/// Whether all triangles from index `first` on are wider than `width`. Rounding gives narrower ones any plane, or none.
bool all_wider(const Fragment& f, std::size_t first, double width) {
  for (std::size_t k = first; k < f.indices.size(); k += 3) {
    const Vec3d a = to_double(f.positions[f.indices[k]]), ab = to_double(f.positions[f.indices[k + 1]]) - a,
                ac = to_double(f.positions[f.indices[k + 2]]) - a, bc = ac - ab, n = cross(ab, ac);
    const double longest = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
    if (!(dot(n, n) > width * width * longest)) return false;
  }
  return true;
}

/// Number of triangles at the beginning of a fragment that may bend inwards. The others are cuts by the bisectors of one
/// cell, which is convex. Corners were rounded to the seam lattice. So the number is only known if the fragment is far
/// wider than a lattice step, and each cut is wider than a few steps: corners of a cell that are closer than that become
/// one. (The width of a convex body is at least 2 V / A.)
std::optional<std::size_t> count_uncut(const Fragment& f, const Vec3d& lattice_step) {
  constexpr double kWide = 1e4, kClear = 16;
  // No hull has more triangles than this, and no loop over them has to be polled.
  const bool is_known = f.bodies.empty() && f.sites.size() == 1 && f.open_edges == 0 && f.caps.size() == 1 &&
                        f.caps[0].first + f.caps[0].count == f.indices.size() &&
                        f.caps[0].count / 3 <= 2 * kMaxHullPoints &&
                        2 * f.mass.volume > kWide * length(lattice_step) * f.mass.area &&
                        all_wider(f, f.caps[0].first, kClear * length(lattice_step));
  if (!is_known) return std::nullopt;
  return f.caps[0].first / 3;
}

/// Adds one hull for each body.
void add_bodies(const FragmentSet& set, const Fragment& f, HullMaker& maker, FragmentHulls& out,
                const Execution& execution) {
  if (f.bodies.empty()) {
    collect_corners(f, maker, execution);
    const BodySurface surface(f.indices, maker.corner_of, count_uncut(f, set.lattice_step));
    const bool is_known =
        surface.uncut() == 0 &&
        add_convex(maker.corners, surface, {f.mass.volume, f.mass.area, f.mass.center_of_mass - f.pivot},
                   maker.rounding, out);
    if (!is_known) add_hull(maker.corners, surface, maker, out, execution);
  }
  for (const std::vector<Vec3f>& body : f.bodies) add_hull(body, {}, maker, out, execution);
}

}  // namespace

HullReport CollisionHulls::report() const {
  HullReport sum;
  for (const FragmentHulls& f : of_fragment) {
    sum.hulls += static_cast<std::uint32_t>(f.hulls.size());
    sum.flat += f.flat;
    sum.simplified += f.simplified;
    sum.excess = std::max(sum.excess, f.excess);
  }
  return sum;
}

CollisionHulls make_collision_hulls(const FragmentSet& set, CollisionHulls known, const HullLimits& limits,
                                    const Execution& execution) {
  CollisionHulls out = std::move(known);
  out.of_fragment.resize(set.fragments.size());
  parallel_for(execution, set.fragments.size(), 8, [&](std::size_t begin, std::size_t end) {
    HullMaker& maker = thread_scratch<HullMaker>();
    maker.rounding = rounding_of(set);
    for (std::size_t k = begin; k < end; ++k) {
      const Fragment& f = set.fragments[k];
      FragmentHulls& hulls = out.of_fragment[k];
      if (f.positions.empty() || hulls.shared) continue;
      if (hulls.hulls.empty()) add_bodies(set, f, maker, hulls, execution);
      hulls.excess = f.mass.volume > 0 ? hulls.volume / f.mass.volume : 0;
      if (hulls.excess > limits.excess && limits.count > 1) {
        collect_corners(f, maker, execution);
        divide_hulls(f, limits, maker, hulls, execution);
      }
    }
  });
  return out;
}

}  // namespace fracture
