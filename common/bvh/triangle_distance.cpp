#include "common/bvh/triangle_distance.hpp"

#include <algorithm>
#include <cmath>

#include "common/bvh/surface_tree.hpp"

namespace fracture {
namespace {

using Corners = std::array<Vec3d, 3>;

/// Heights of the corners over the plane of t, m; none if t is a needle, whose plane depends on rounding.
struct Heights {
  static constexpr double kNeedle = 1e-3;
  double least = 0, most = 0;
  Heights(const Corners& t, const Corners& corners) {
    const Vec3d across = cross(t[1] - t[0], t[2] - t[0]);
    const double size = length(across), longest = std::max(length(t[1] - t[0]), length(t[2] - t[0]));
    if (!(size > kNeedle * longest * longest)) return;
    const Vec3d normal = (1 / size) * across;
    const double a = dot(normal, corners[0] - t[0]), b = dot(normal, corners[1] - t[0]),
                 c = dot(normal, corners[2] - t[0]);
    least = std::min({a, b, c});
    most = std::max({a, b, c});
  }
  bool beyond(double distance) const { return least > distance || most < -distance; }
};

/// Whether an edge of s passes through t. Edges that pass near an edge of t are not decided reliably.
bool pierces(const Corners& s, const Corners& t) {
  const Vec3d normal = cross(t[1] - t[0], t[2] - t[0]);
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d &from = s[k], &to = s[(k + 1) % 3];
    const double p = dot(normal, from - t[0]), q = dot(normal, to - t[0]);
    if (!((p > 0 && q < 0) || (p < 0 && q > 0))) continue;
    const Vec3d x = from + (p / (p - q)) * (to - from);
    bool inside = true;
    for (std::size_t i = 0; i < 3; ++i)
      inside = inside && dot(normal, cross(t[(i + 1) % 3] - t[i], x - t[i])) > 0;
    if (inside) return true;
  }
  return false;
}

/// Calls ends(distance) for each corner with the other triangle and for each pair of edges, until it returns
/// true. The minimum of these is the distance of triangles that do not pierce each other.
template <class Ends>
bool any_distance(const Corners& s, const Corners& t, const Ends& ends) {
  for (std::size_t k = 0; k < 3; ++k)
    if (ends(distance_to_triangle(s[k], t[0], t[1], t[2])) ||
        ends(distance_to_triangle(t[k], s[0], s[1], s[2])))
      return true;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k)
      if (ends(distance_of_segments(s[i], s[(i + 1) % 3], t[k], t[(k + 1) % 3]))) return true;
  return false;
}

}  // namespace

double distance_of_segments(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const Vec3d ab = b - a, cd = d - c, ca = a - c;
  const double ab2 = dot(ab, ab), cd2 = dot(cd, cd), on_cd = dot(cd, ca), on_ab = dot(ab, ca);
  const auto clamped = [](double x) { return x > 0 ? std::fmin(x, 1) : 0.0; };  // 0 for NaN
  double s = 0, t = 0;
  if (cd2 > 0) {
    const double both = dot(ab, cd), across = ab2 * cd2 - both * both;
    if (across > 0) s = clamped((both * on_cd - on_ab * cd2) / across);
    const double along = both * s + on_cd;
    t = clamped(along / cd2);
    if (ab2 > 0 && (along < 0 || along > cd2)) s = clamped((t * both - on_ab) / ab2);
  } else if (ab2 > 0) {
    s = clamped(-on_ab / ab2);
  }
  return length(ca + s * ab - t * cd);
}

bool are_within(const Corners& s, const Corners& t, double distance) {
  if (Heights(t, s).beyond(distance) || Heights(s, t).beyond(distance)) return false;
  return any_distance(s, t, [&](double d) { return d < distance; }) || pierces(s, t) || pierces(t, s);
}

double distance_of_triangles(const Corners& s, const Corners& t, double most) {
  if (Heights(t, s).beyond(most) || Heights(s, t).beyond(most)) return most;
  double least = most;
  any_distance(s, t, [&](double d) {
    least = std::fmin(least, d);
    return false;
  });
  return pierces(s, t) || pierces(t, s) ? 0 : least;
}

}  // namespace fracture
