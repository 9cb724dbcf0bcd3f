#include "common/hollow/inner_surface.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/id.hpp"
#include "common/base/pacer.hpp"
#include "common/hollow/deep_points.hpp"
#include "common/hollow/simplify.hpp"

namespace fracture::hollow_detail {
namespace {

/// Number of steps into which an edge of the lattice is divided.
constexpr int kParts = 16;
/// Minimum number of lattice points in a cavity.
constexpr std::uint32_t kSmallest = 8;

/// The next larger step whose mantissa has only three binary digits. Floats represent sixteenths of such
/// steps exactly, within the range of their multiples.
double coarser(double step) {
  int exponent = 0;
  const double fraction = std::frexp(step, &exponent);  // 4, 5, 6 or 7 eighths
  return std::ldexp(std::floor(8 * fraction) + 1, exponent - 3);
}
constexpr double kFloatSteps = 4 * kParts;

/// Number of triangles of a surface per square of the lattice (measured on balls).
constexpr double kTrianglesPerSquare = 9;

double area_of(const SurfaceTree& surface, Pacer& pacer) {
  double twice = 0;
  for (const auto& [a, b, c] : surface.corners()) {
    pacer.step();
    twice += length(cross(b - a, c - a));
  }
  return twice / 2;
}

/// Approximate number of lattice points for this box.
double expected_points(const Box& box, double step) {
  const Vec3d size = box.size();
  return (size.x / step + 4) * (size.y / step + 4) * (size.z / step + 4);
}

class March {
 public:
  March(const SurfaceTree& surface, const Box& box, double thickness, double step, const Execution& execution)
      : surface_(surface),
        lattice_(box, step),
        depth_(std::sqrt(thickness * thickness + step * step)),
        execution_(execution),
        pacer_(execution) {}

  /// Returns an empty surface if it would have more than `most` triangles, and sets `too_many` to their
  /// number.
  InnerSurface run(std::uint32_t most, std::uint32_t& too_many) {
    // Points from which moving by a sixteenth of an edge still leads to a point that is deep enough.
    const double depth = depth_ + 1.0001 * std::sqrt(3.0) / kParts * lattice_.step();
    deep_ = deep_points(surface_, lattice_, depth, kSmallest, execution_);
    // The number of triangles does not depend on the positions of corners on their edges, which take most of
    // the time to compute.
    std::uint32_t count = 0;
    lattice_.each_cube([&](std::uint32_t point) {
      pacer_.step();
      count += triangles_in(point);
    });
    if (count > most) {
      too_many = count;
      return {};
    }
    out_.positions.reserve(count / 2 + 2);
    out_.triangles.reserve(count);
    corner_of_edge_.assign(std::size_t{8} * lattice_.points(), kNoIndex);
    lattice_.each_cube([&](std::uint32_t point) {
      pacer_.step();
      if (is_divided(point))
        for (const auto& [first, second] : kPaths) tetrahedron(point, {0, first, second, 7});
    });
    return std::move(out_);
  }

 private:
  /// The six tetrahedra of a cube, each as the path of its edges from corner 0 to corner 7.
  static constexpr std::uint32_t kPaths[6][2] = {{1, 3}, {1, 5}, {2, 3}, {2, 6}, {4, 5}, {4, 6}};

  bool is_divided(std::uint32_t cube) const {
    std::uint32_t deep = 0;
    for (std::uint32_t bits = 0; bits < 8; ++bits) deep += deep_[lattice_.neighbour(cube, bits)];
    return deep > 0 && deep < 8;
  }

  std::uint32_t triangles_in(std::uint32_t cube) const {
    if (!is_divided(cube)) return 0;
    constexpr std::uint32_t kOfDeepCorners[5] = {0, 1, 2, 1, 0};
    const auto deep = [&](std::uint32_t bits) { return deep_[lattice_.neighbour(cube, bits)]; };
    std::uint32_t count = 0;
    for (const auto& [first, second] : kPaths)
      count += kOfDeepCorners[deep(0) + deep(first) + deep(second) + deep(7)];
    return count;
  }

  /// Edges of a cube: one end inside, and one outside.
  template <std::size_t N>
  using Edges = std::array<std::array<std::uint32_t, 2>, N>;
  /// Corners of a cube by their bits; each corner's bits contain those of the previous one.
  using Tetrahedron = std::array<std::uint32_t, 4>;

  void tetrahedron(std::uint32_t cube, const Tetrahedron& corners) {
    std::array<std::uint32_t, 4> in{}, out{};
    std::size_t ins = 0, outs = 0;
    for (const std::uint32_t bits : corners)
      (deep_[lattice_.neighbour(cube, bits)] ? in[ins++] : out[outs++]) = bits;
    if (ins == 1) {
      polygon(cube, Edges<3>{{{in[0], out[0]}, {in[0], out[1]}, {in[0], out[2]}}}, in[0]);
    } else if (ins == 3) {
      polygon(cube, Edges<3>{{{in[0], out[0]}, {in[1], out[0]}, {in[2], out[0]}}}, in[0]);
    } else if (ins == 2) {
      // Around the tetrahedron, neighbouring edges share an end.
      polygon(cube, Edges<4>{{{in[0], out[0]}, {in[0], out[1]}, {in[1], out[1]}, {in[1], out[0]}}}, in[0]);
    }
  }

  static Vec3d of_bits(std::uint32_t bits) {
    return {1.0 * (bits & 1), 1.0 * (bits >> 1 & 1), 1.0 * (bits >> 2 & 1)};
  }

  /// `edges`: in order around the polygon.
  template <std::size_t N>
  void polygon(std::uint32_t cube, const Edges<N>& edges, std::uint32_t inside) {
    // The orientation does not change while corners move along their edges, so it is computed from the
    // middles.
    std::array<Vec3d, 3> middle;
    for (std::size_t k = 0; k < 3; ++k) middle[k] = 0.5 * (of_bits(edges[k][0]) + of_bits(edges[k][1]));
    const bool faces_in =
        dot(cross(middle[1] - middle[0], middle[2] - middle[0]), of_bits(inside) - middle[0]) > 0;
    std::array<std::uint32_t, N> corner;
    for (std::size_t k = 0; k < N; ++k) corner[faces_in ? k : N - 1 - k] = corner_on(cube, edges[k]);
    for (std::size_t k = 2; k < N; ++k) out_.triangles.push_back({corner[0], corner[k - 1], corner[k]});
  }

  /// Returns the corner of the surface on an edge: as near to the outer end as is deep enough.
  std::uint32_t corner_on(std::uint32_t cube, const std::array<std::uint32_t, 2>& edge) {
    const std::uint32_t low = edge[0] & edge[1], bits = edge[0] ^ edge[1];
    std::uint32_t& corner = corner_of_edge_[std::size_t{8} * lattice_.neighbour(cube, low) + bits];
    if (corner != kNoIndex) return corner;
    const Vec3d from = lattice_.place(lattice_.neighbour(cube, edge[0]));
    const Vec3d along = (1.0 / kParts) * (lattice_.place(lattice_.neighbour(cube, edge[1])) - from);
    int deep = 1, shallow = kParts;
    while (shallow - deep > 1) {
      const int k = (deep + shallow) / 2;
      (surface_.within(from + 1.0 * k * along, depth_, pacer_) ? shallow : deep) = k;
    }
    const Vec3d place = from + 1.0 * deep * along;
    corner = static_cast<std::uint32_t>(out_.positions.size());
    out_.positions.push_back(
        {static_cast<float>(place.x), static_cast<float>(place.y), static_cast<float>(place.z)});
    return corner;
  }

  const SurfaceTree& surface_;
  Lattice lattice_;
  double depth_;
  const Execution& execution_;
  Pacer pacer_;
  std::vector<std::uint8_t> deep_;
  std::vector<std::uint32_t> corner_of_edge_;  ///< [8 * lower end + direction]
  InnerSurface out_;
};

/// Larger triangles may come nearer to the outside than the corners from which they were made. So a share of
/// the corners' extra depth is reserved for this.
InnerSurface as_simple_as_may_be(InnerSurface inner, const SurfaceTree& surface, double thickness,
                                 double step, const Execution& execution) {
  const double to_spare = std::sqrt(thickness * thickness + step * step) - thickness;
  for (double tolerance = step / 8; tolerance > step / 64; tolerance /= 4) {
    InnerSurface simple = simplified(inner, tolerance, surface, thickness + to_spare / 4, execution);
    if (is_deep(simple, surface, thickness, execution) && !crosses_itself(simple, execution)) return simple;
  }
  return inner;
}

}  // namespace

InnerSurface inner_surface(const SurfaceTree& surface, const Box& box, double thickness,
                           const InnerSurfaceLimits& limits, const Execution& execution,
                           InnerSurfaceLimits* other) {
  constexpr std::uint32_t kAnyNumber = 0xffffffffu;
  InnerSurfaceLimits unused;
  InnerSurfaceLimits& enough = other ? *other : unused;
  enough = {kAnyNumber, kAnyNumber, limits.lattice_points};
  double reach = 0;
  for (int axis = 0; axis < 3; ++axis) reach = std::fmax(reach, std::fmax(-box.min[axis], box.max[axis]));
  const double least = std::fmax(kFloatSteps * reach / (1 << 23), box.longest_side() / limits.lattice_points);
  Pacer pacer(execution);
  const double area = area_of(surface, pacer);
  double step = std::ldexp(1, std::ilogb(std::fmax(thickness / 2, least)));
  for (;; step = coarser(step)) {
    if (step < least || expected_points(box, step) > limits.lattice_points) continue;
    const double expected = kTrianglesPerSquare / 2 * area / (step * step);
    if (!(expected > limits.marched)) break;
    if (expected < kAnyNumber)
      enough.marched = std::min(enough.marched, static_cast<std::uint32_t>(std::ceil(expected)));
  }
  for (;; step = coarser(step)) {
    execution.poll();
    if (2 * std::sqrt(thickness * thickness + step * step) >= box.longest_side()) return {};
    std::uint32_t too_many = 0;
    InnerSurface inner = March(surface, box, thickness, step, execution).run(limits.marched, too_many);
    if (too_many > 0) {
      enough.marched = std::min(enough.marched, too_many);
      continue;
    }
    inner = as_simple_as_may_be(std::move(inner), surface, thickness, step, execution);
    if (inner.triangles.size() <= limits.triangles) return inner;
    enough.triangles = std::min(enough.triangles, static_cast<std::uint32_t>(inner.triangles.size()));
  }
}

}  // namespace fracture::hollow_detail
