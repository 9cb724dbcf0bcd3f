#include "common/solid/nesting.hpp"

#include <algorithm>
#include <cmath>

#include "common/solid/float_predicates.hpp"

namespace fracture::solid_detail {
namespace {

/// Rays along +x against all triangles, which stand in a grid over the (y, z) plane.
///
/// The ray through (y, z) is taken at (y + ε, z + ε²), so that it meets no vertex and no edge and the
/// crossings of a closed shell sum up exactly: every sign is that of a 2D orientation, and a zero is decided
/// by the first non-zero coefficient of ε, ε² (simulation of simplicity, Edelsbrunner & Mücke 1990).
class RayCaster {
 public:
  explicit RayCaster(const Surface& surface, const Shells& shells) : surface_(surface), shells_(shells) {
    for (const Shell& shell : shells.list) box_.add(shell.box);
    const std::size_t count = surface.triangles.size();
    side_ = std::min<std::uint32_t>(
        1024, 1 + static_cast<std::uint32_t>(std::sqrt(static_cast<double>(count) / 2)));
    start_.assign(static_cast<std::size_t>(side_) * side_ + 2, 0);
    for (int pass = 0; pass < 2; ++pass) {
      for (TriangleId t = 0; t < count; ++t) {
        Box box;
        for (const VertexId v : surface.triangles[t]) box.add(to_double(surface.positions[v]));
        const std::uint32_t y1 = cell(box.max.y, 1), z1 = cell(box.max.z, 2);
        for (std::uint32_t z = cell(box.min.z, 2); z <= z1; ++z)
          for (std::uint32_t y = cell(box.min.y, 1); y <= y1; ++y) {
            if (pass == 0)
              ++start_[z * side_ + y + 2];
            else
              items_[start_[z * side_ + y + 1]++] = t;
          }
      }
      if (pass == 1) break;
      for (std::size_t i = 2; i < start_.size(); ++i) start_[i] += start_[i - 1];
      items_.resize(start_.back());
    }
  }

  struct Wind {
    std::uint32_t shell;
    int number;
  };
  /// The shells with a non-zero winding number at p, ascending, without `self`. Returns false when p lies on
  /// one of them.
  bool cast(const Vec3f& p, std::uint32_t self, std::vector<Wind>& winds) {
    winds.clear();
    bool clear = true;
    const std::uint32_t at = cell(p.z, 2) * side_ + cell(p.y, 1);
    for (std::uint32_t i = start_[at]; i < start_[at + 1]; ++i) {
      const TriangleId t = items_[i];
      const std::uint32_t shell = shells_.of_triangle[t];
      if (shell == self) continue;
      const Vec3f &a = surface_.positions[surface_.triangles[t][0]],
                  &b = surface_.positions[surface_.triangles[t][1]],
                  &c = surface_.positions[surface_.triangles[t][2]];
      const int ab = side(a, b, p), bc = side(b, c, p), ca = side(c, a, p);
      if (ab != bc || bc != ca)
        continue;  // the perturbed ray passes by (an edge-on triangle has mixed signs)
      // Projected along +x a triangle with its normal towards +x is counter-clockwise: ab > 0, the ray leaves
      // through it.
      const int height = sign_orient3d(a, b, c, p);
      if (height == 0) clear = false;
      if (height * ab >= 0) continue;  // the crossing lies at or before p
      winds.push_back({shell, ab});
    }
    std::sort(winds.begin(), winds.end(), [](const Wind& x, const Wind& y) { return x.shell < y.shell; });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < winds.size();) {
      Wind sum{winds[i].shell, 0};
      for (; i < winds.size() && winds[i].shell == sum.shell; ++i) sum.number += winds[i].number;
      if (sum.number != 0) winds[kept++] = sum;
    }
    winds.resize(kept);
    return clear;
  }

 private:
  /// Which side of the line ab (in the plane of y and z) the point (p.y + ε, p.z + ε²) lies on; 0 only if a
  /// and b coincide.
  static int side(const Vec3f& a, const Vec3f& b, const Vec3f& p) {
    const int sign = sign_orient2d(drop_axis(a, 0), drop_axis(b, 0), drop_axis(p, 0));
    if (sign != 0) return sign;
    // orient2d = (by - ay)(pz - az) - (bz - az)(py - ay): ε has the coefficient -(bz - az), ε² has (by - ay).
    if (a.z != b.z) return a.z > b.z ? 1 : -1;
    return b.y > a.y ? 1 : b.y < a.y ? -1 : 0;
  }
  std::uint32_t cell(double value, int axis) const {
    const double width = box_.max[axis] - box_.min[axis];
    if (!(width > 0)) return 0;
    const double t = (value - box_.min[axis]) / width * side_;
    return static_cast<std::uint32_t>(std::fmin(std::fmax(t, 0.0), static_cast<double>(side_ - 1)));
  }

  const Surface& surface_;
  const Shells& shells_;
  Box box_;
  std::uint32_t side_ = 1;
  std::vector<std::uint32_t> start_;
  std::vector<TriangleId> items_;
};

bool inside(const Box& inner, const Box& outer) {
  for (int axis = 0; axis < 3; ++axis)
    if (inner.min[axis] < outer.min[axis] || inner.max[axis] > outer.max[axis]) return false;
  return true;
}

}  // namespace

Nesting nest_shells(const Surface& surface, const Shells& shells, const Execution& execution) {
  const auto count = static_cast<std::uint32_t>(shells.list.size());
  Nesting nesting;
  nesting.reversed.assign(count, 0);
  nesting.cavity_of.assign(count, kNoIndex);
  std::size_t inward = 0, usable = 0;
  for (const Shell& shell : shells.list) {
    inward += !shell.flat && shell.volume < 0;
    usable += !shell.flat;
  }
  if (inward == 0) return nesting;
  if (usable == inward && inward == 1) {
    for (std::uint32_t i = 0; i < count; ++i) nesting.reversed[i] = !shells.list[i].flat;
    return nesting;
  }

  // winds[i]: which shells wind around shell i, as the file orients them.
  RayCaster caster(surface, shells);
  std::vector<std::vector<RayCaster::Wind>> winds(count);
  std::vector<std::vector<TriangleId>> probes(count);
  constexpr std::size_t kProbes = 64;  // triangles whose corners are tried until one lies on no other shell
  for (TriangleId t = 0; t < surface.triangles.size(); ++t) {
    auto& list = probes[shells.of_triangle[t]];
    if (list.size() < kProbes) list.push_back(t);
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    if (shells.list[i].flat) continue;
    execution.poll();
    bool clear = false;
    for (std::size_t k = 0; k < probes[i].size() && !clear; ++k)
      for (int corner = 0; corner < 3 && !clear; ++corner)
        clear = caster.cast(surface.positions[surface.triangles[probes[i][k]][corner]], i, winds[i]);
    std::erase_if(winds[i], [&](const RayCaster::Wind& w) { return shells.list[w.shell].flat; });
  }

  bool outermost_inward = false, outermost_outward = false;
  for (std::uint32_t i = 0; i < count; ++i)
    if (!shells.list[i].flat && winds[i].empty())
      (shells.list[i].volume < 0 ? outermost_inward : outermost_outward) = true;
  const bool all_reversed = outermost_inward && !outermost_outward;
  const auto outward = [&](std::uint32_t i) {
    return (shells.list[i].volume > 0) != (nesting.reversed[i] != 0);
  };
  if (all_reversed)
    for (std::uint32_t i = 0; i < count; ++i) nesting.reversed[i] = !shells.list[i].flat;

  // Largest first, so that the orientation of whatever encloses a shell is settled before the shell's own.
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < count; ++i)
    if (!shells.list[i].flat) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::fabs(shells.list[a].volume) > std::fabs(shells.list[b].volume);
  });
  for (const std::uint32_t i : order) {
    if (outward(i)) continue;
    int winding = 0;
    std::uint32_t parent = kNoIndex;
    for (const RayCaster::Wind& w : winds[i]) {
      const int number = nesting.reversed[w.shell] ? -w.number : w.number;
      winding += number;
      if (number > 0 && outward(w.shell) && inside(shells.list[i].box, shells.list[w.shell].box) &&
          (parent == kNoIndex || shells.list[w.shell].volume * (nesting.reversed[w.shell] ? -1 : 1) <
                                     shells.list[parent].volume * (nesting.reversed[parent] ? -1 : 1)))
        parent = w.shell;
    }
    if (winding >= 1 && parent != kNoIndex)
      nesting.cavity_of[i] = parent;
    else
      nesting.reversed[i] ^= 1;
  }
  return nesting;
}

}  // namespace fracture::solid_detail
