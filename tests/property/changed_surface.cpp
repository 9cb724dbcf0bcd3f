#include "tests/property/changed_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <vector>

#include "common/base/random.hpp"
#include "common/solid/cut_materials.hpp"

namespace fracture::test {
namespace {

using Place = std::array<float, 3>;
Place place_of(const Fragment& f, std::uint32_t v) {
  const Vec3f& p = f.positions[v];
  return {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};
}

/// A triangle of a fragment in a triangle of the mesh.
struct Covering {
  std::array<Vec3d, 3> corners;
  std::uint64_t fragment;
};
using Coverings = std::vector<std::vector<Covering>>;  // per triangle of the mesh

Coverings coverings_of(const FragmentSet& set, std::size_t triangles) {
  Coverings all(triangles);
  for (const Fragment& f : set.fragments)
    for (const FragmentPrimitive& p : f.primitives) {
      if (is_of_cuts(p.material) || p.material >= triangles) continue;
      for (std::uint32_t k = p.first_index; k < p.first_index + p.index_count; k += 3) {
        const auto at = [&](std::uint32_t n) { return to_double(f.positions[f.indices[k + n]]) + f.pivot; };
        all[p.material].push_back({{at(0), at(1), at(2)}, f.id});
      }
    }
  return all;
}

/// The smallest barycentric coordinate of the point; below 0 outside.
double depth_in(const Covering& c, const Vec3d& p) {
  const Vec3d n = cross(c.corners[1] - c.corners[0], c.corners[2] - c.corners[0]);
  const double all = dot(n, n);
  if (!(all > 0)) return -HUGE_VAL;
  double least = HUGE_VAL;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d &a = c.corners[(k + 1) % 3], &b = c.corners[(k + 2) % 3];
    least = std::fmin(least, dot(n, cross(b - a, p - a)) / all);
  }
  return least;
}

std::optional<std::uint64_t> fragment_at(const std::vector<Covering>& coverings, const Vec3d& p) {
  const Covering* best = nullptr;
  double deepest = -1e-2;  // positions are rounded, so the point may lie just outside of all
  for (const Covering& c : coverings)
    if (const double depth = depth_in(c, p); depth > deepest) {
      deepest = depth;
      best = &c;
    }
  if (!best) return std::nullopt;
  return best->fragment;
}

}  // namespace

double farthest_new_vertex(const FragmentSet& before, const FragmentSet& after, const Vec3d& from,
                           bool outside) {
  std::set<Place> was;
  for (const Fragment& f : before.fragments)
    for (std::uint32_t v = 0; v < f.positions.size(); ++v) was.insert(place_of(f, v));
  double farthest = 0;
  for (const Fragment& f : after.fragments)
    for (const FragmentPrimitive& p : f.primitives) {
      if (outside && is_of_cuts(p.material)) continue;
      for (std::uint32_t k = p.first_index; k < p.first_index + p.index_count; ++k) {
        const std::uint32_t v = f.indices[k];
        if (!was.contains(place_of(f, v)))
          farthest = std::max(farthest, length(to_double(f.positions[v]) + f.pivot - from));
      }
    }
  return farthest;
}

ChangedSurface changed_surface(const FragmentSet& before, const FragmentSet& after, const Mesh& traced,
                               const Vec3d& from, int count, std::uint64_t seed) {
  const Coverings was = coverings_of(before, traced.triangles.size()),
                  is = coverings_of(after, traced.triangles.size());
  ChangedSurface result;
  std::uint64_t state = seed;
  const auto random = [&] {
    state = mix64(state, 1);
    return static_cast<double>(state >> 11) * 0x1p-53;
  };
  for (std::size_t t = 0; t < traced.triangles.size(); ++t)
    for (int k = 0; k < count; ++k) {
      double u = random(), v = random();
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      const auto& corners = traced.triangles[t];
      const Vec3d a = to_double(traced.positions[corners[0]]), b = to_double(traced.positions[corners[1]]),
                  c = to_double(traced.positions[corners[2]]);
      const Vec3d p = a + u * (b - a) + v * (c - a);
      const auto first = fragment_at(was[t], p), second = fragment_at(is[t], p);
      ++result.points;
      if (!first || !second) {
        ++result.uncovered;
      } else if (*first != *second) {
        ++result.changed;
        result.farthest = std::max(result.farthest, length(p - from));
      }
    }
  return result;
}

}  // namespace fracture::test
