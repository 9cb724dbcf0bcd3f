#include "tests/property/judge.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/base/random.hpp"
#include "tests/property/violations.hpp"

namespace fracture::test {
namespace {

/// Signed crossings of the ray from q in direction +x. Sets `doubt` if the ray passes an edge, or q a face,
/// too closely for double arithmetic.
int winding(const std::vector<std::array<Vec3d, 3>>& triangles, const Vec3d& q, double scale, bool& doubt) {
  int w = 0;
  for (const auto& t : triangles) {
    const Vec3d a = t[0] - q, b = t[1] - q, c = t[2] - q;
    if (std::max({a.x, b.x, c.x}) < 0 || std::min({a.y, b.y, c.y}) > 0 || std::max({a.y, b.y, c.y}) < 0 ||
        std::min({a.z, b.z, c.z}) > 0 || std::max({a.z, b.z, c.z}) < 0)
      continue;
    const double ab = a.y * b.z - a.z * b.y, bc = b.y * c.z - b.z * c.y, ca = c.y * a.z - c.z * a.y;
    const double tiny = 1e-7 * scale * scale;
    const bool inside = (ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0);
    if (std::fabs(ab) < tiny || std::fabs(bc) < tiny || std::fabs(ca) < tiny) {
      const int up = (ab > -tiny) + (bc > -tiny) + (ca > -tiny),
                down = (ab < tiny) + (bc < tiny) + (ca < tiny);
      doubt |= up == 3 || down == 3;
      continue;
    }
    if (!inside) continue;
    const Vec3d n = cross(b - a, c - a);
    const double x = dot(n, a) / n.x;
    doubt |= std::fabs(x) < 1e-6 * scale;
    if (x > 0) w += n.x > 0 ? 1 : -1;
  }
  return w;
}

}  // namespace

Mesh with_traced_triangles(Mesh mesh) {
  mesh.material.resize(mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.material.size(); ++t) mesh.material[t] = t;
  return mesh;
}

namespace {

void expect_none(const Violations& violations) {
  for (const std::string& violation : violations) ADD_FAILURE() << violation;
}

}  // namespace

void expect_closed(const FragmentSet& set) { expect_none(closed_violations(set)); }

void expect_partition(const FragmentSet& set, double volume, double area) {
  EXPECT_LE(std::fabs(set.certificate.pocket_volume), 1e-9 * volume);
  expect_none(partition_violations(set, {.volume = volume, .area = area, .magnitude = volume}));
}

void expect_outside_untouched(const FragmentSet& set, const Mesh& traced) {
  expect_none(outside_violations(set, traced));
}

namespace {

using Corners = std::array<Vec3d, 3>;

/// Whether the segment pq passes through the triangle. Both ends and the crossing must be farther than the
/// tolerance from its plane and sides. Uses barycentric coordinates from a linear system (Möller & Trumbore
/// 1997).
bool pierces(const Vec3d& p, const Vec3d& q, const Corners& t, double tolerance) {
  const Vec3d e = t[1] - t[0], f = t[2] - t[0], d = q - p, n = cross(e, f);
  const double area = length(n), det = -dot(d, n);
  if (!(area > 0) || std::fabs(dot(p - t[0], n)) <= tolerance * area ||
      std::fabs(dot(q - t[0], n)) <= tolerance * area)
    return false;
  const double along = dot(p - t[0], n) / det;
  if (!(along > 0 && along < 1)) return false;
  const Vec3d m = cross(p - t[0], d);
  const double u = dot(f, m) / det, v = -dot(e, m) / det;
  // A barycentric coordinate is the distance from the side divided by the height of the triangle above it.
  return u * area > tolerance * length(f) && v * area > tolerance * length(e) &&
         (1 - u - v) * area > tolerance * length(f - e);
}

/// Whether the triangle s lies on both sides of the plane of t, by more than the tolerance. If not, it only
/// touches t: moved by the tolerance, it would lie on one side.
bool on_both_sides(const Corners& s, const Corners& t, double tolerance) {
  const Vec3d n = cross(t[1] - t[0], t[2] - t[0]);
  double least = 0, most = 0;
  for (const Vec3d& p : s) {
    least = std::fmin(least, dot(n, p - t[0]));
    most = std::fmax(most, dot(n, p - t[0]));
  }
  return most > tolerance * length(n) && least < -tolerance * length(n);
}

}  // namespace

void expect_no_self_crossing(const FragmentSet& set, double tolerance) {
  for (std::size_t n = 0; n < set.fragments.size(); ++n) {
    const Fragment& f = set.fragments[n];
    std::vector<Corners> triangles;
    std::vector<Box> boxes;
    std::vector<std::uint32_t> order;
    for (std::size_t k = 0; k < f.indices.size(); k += 3) {
      triangles.push_back({to_double(f.positions[f.indices[k]]), to_double(f.positions[f.indices[k + 1]]),
                           to_double(f.positions[f.indices[k + 2]])});
      boxes.emplace_back();
      for (const Vec3d& p : triangles.back()) boxes.back().add(p);
      order.push_back(static_cast<std::uint32_t>(order.size()));
    }
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return boxes[a].min.x < boxes[b].min.x; });
    int crossings = 0;
    for (std::size_t i = 0; i < order.size(); ++i)
      for (std::size_t j = i + 1; j < order.size() && boxes[order[j]].min.x <= boxes[order[i]].max.x; ++j) {
        if (!boxes[order[i]].intersects(boxes[order[j]])) continue;
        const Corners &s = triangles[order[i]], &t = triangles[order[j]];
        if (!on_both_sides(s, t, tolerance) || !on_both_sides(t, s, tolerance)) continue;
        bool cross = false;
        for (std::size_t k = 0; k < 3; ++k)
          cross |= pierces(s[k], s[(k + 1) % 3], t, tolerance) || pierces(t[k], t[(k + 1) % 3], s, tolerance);
        crossings += cross;
      }
    EXPECT_EQ(crossings, 0) << "pairs of triangles of fragment " << n << " of " << f.indices.size() / 3;
  }
}

void expect_voronoi(const FragmentSet& set, const Mesh& mesh, std::span<const Vec3d> sites, int count,
                    std::uint64_t seed) {
  Box box;
  std::vector<std::array<Vec3d, 3>> whole;
  for (const auto& t : mesh.triangles) {
    whole.push_back(
        {to_double(mesh.positions[t[0]]), to_double(mesh.positions[t[1]]), to_double(mesh.positions[t[2]])});
    for (const Vec3d& p : whole.back()) box.add(p);
  }
  const double scale = box.longest_side();
  struct Body {
    Box box;
    std::vector<std::array<Vec3d, 3>> triangles;
  };
  std::vector<Body> bodies(set.fragments.size());
  for (std::size_t n = 0; n < bodies.size(); ++n) {
    const Fragment& f = set.fragments[n];
    for (std::size_t k = 0; k < f.indices.size(); k += 3) {
      std::array<Vec3d, 3> t;
      for (int c = 0; c < 3; ++c) t[c] = to_double(f.positions[f.indices[k + c]]) + f.pivot;
      bodies[n].triangles.push_back(t);
      for (const Vec3d& p : t) bodies[n].box.add(p);
    }
  }
  Random random(seed);
  int judged = 0, inside = 0;
  for (int k = 0; k < count; ++k) {
    Vec3d q;
    for (int a = 0; a < 3; ++a) q[a] = box.min[a] + random.uniform() * (box.max[a] - box.min[a]);
    // The nearest site, and whether the second is too close to decide.
    double best = HUGE_VAL, second = HUGE_VAL;
    std::vector<std::uint32_t> nearest;
    for (std::uint32_t s = 0; s < sites.size(); ++s) {
      const double d = dot(sites[s] - q, sites[s] - q);
      if (d < best) {
        if (!nearest.empty() && !(sites[nearest[0]] == sites[s])) second = best;
        best = d;
        nearest = {s};
      } else if (sites[nearest[0]] == sites[s]) {
        nearest.push_back(s);
      } else {
        second = std::min(second, d);
      }
    }
    if (second - best < 1e-5 * scale * scale) continue;
    bool doubt = false;
    const int in_solid = winding(whole, q, scale, doubt);
    if (doubt) continue;
    std::vector<std::size_t> holders;
    for (std::size_t n = 0; n < bodies.size(); ++n) {
      if (q.x < bodies[n].box.min.x || q.x > bodies[n].box.max.x || q.y < bodies[n].box.min.y ||
          q.y > bodies[n].box.max.y || q.z < bodies[n].box.min.z || q.z > bodies[n].box.max.z)
        continue;
      const int w = winding(bodies[n].triangles, q, scale, doubt);
      if (w != 0) holders.push_back(n);
    }
    if (doubt) continue;
    ++judged;
    if (in_solid == 0) {
      EXPECT_TRUE(holders.empty()) << "a point outside the solid lies in a fragment";
      continue;
    }
    ++inside;
    ASSERT_EQ(holders.size(), 1u) << "point " << q.x << " " << q.y << " " << q.z;
    const auto& own = set.fragments[holders[0]].sites;
    const bool right = std::any_of(nearest.begin(), nearest.end(), [&](std::uint32_t s) {
      return std::binary_search(own.begin(), own.end(), s);
    });
    EXPECT_TRUE(right) << "nearest site " << nearest[0] << " is not the fragment's";
  }
  EXPECT_GT(judged, count / 4);
  EXPECT_GT(inside, 0);
}

}  // namespace fracture::test
