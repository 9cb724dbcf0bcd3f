#include "common/sites/masonry.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/sites/arithmetic.hpp"

namespace fracture {
namespace {

// Measured on sample meshes: walls, crates and houses have at least two thirds of their surface perpendicular
// to three axes, and so does a square column with a base. For a fox, a bottle and a barrel it is one third,
// for a hammer half.
constexpr double kLeastShare = 0.6;
constexpr double kAcross = 0.966;  // cosine of 15 degrees: largest angle between an axis and normals
constexpr double kNear = 0.985;    // of 10 degrees: normals this close are counted together to find an axis
constexpr double kPerpendicular = 0.174;  // sine of 10 degrees
constexpr double kSameAxes = 0.9986;      // cosine of 3 degrees
// Smaller components of an axis are treated as noise in the model; this moves the end of a 4 m wall by at
// most 12 mm.
constexpr double kNoiseOfAxes = 0.003;
/// Stones of rubble are flat: they are kFlat^3, about twice, as wide as they are high.
constexpr double kFlat = 1.25;
const Matrix3 kRubble{{Vec3d{1 / kFlat, 0, 0}, Vec3d{0, kFlat* kFlat, 0}, Vec3d{0, 0, 1 / kFlat}}};

/// Triangles with nearly the same normal.
struct Bin {
  double area = 0;  ///< m²
  Vec3d sum{};      ///< sum of area * normal, with signs chosen so that all point the same way
  void add(const Vec3d& area_normal, double own) {
    area += own;
    sum = sum + area_normal;
  }
};

/// Calls visit(area * normal, area) for each triangle in [first, end) whose area is not zero.
template <class Visit>
void each_normal(const Solid& solid, std::size_t first, std::size_t end, Pacer& pacer, const Visit& visit) {
  for (std::size_t t = first; t < end; ++t) {
    pacer.step(4);
    const Vec3d a = to_double(solid.positions[solid.triangles[t][0]]);
    const Vec3d n = 0.5 * cross(to_double(solid.positions[solid.triangles[t][1]]) - a,
                                to_double(solid.positions[solid.triangles[t][2]]) - a);
    if (const double area = length(n); area > 0) visit(n, area);
  }
}

/// Bins for directions without sign, in steps of a quarter.
using Directions = std::array<Bin, 9 * 9 * 9>;
void add(Directions& bins, const Vec3d& area_normal, double area) {
  int largest = 0;
  for (int k = 1; k < 3; ++k)
    if (std::fabs(area_normal[k]) > std::fabs(area_normal[largest])) largest = k;
  const Vec3d n = area_normal[largest] < 0 ? -1.0 * area_normal : area_normal;
  std::size_t index = 0;
  for (int k = 0; k < 3; ++k)
    index = 9 * index + static_cast<std::size_t>(4 + static_cast<int>(std::nearbyint(4 * (n[k] / area))));
  bins[index].add(n, area);
}

/// Returns the bin mean that has the largest area within ten degrees. With `axis`, prefers means
/// perpendicular to it.
std::optional<Vec3d> most_of(const Directions& bins, const Vec3d* axis, Pacer& pacer) {
  std::vector<std::pair<Vec3d, double>> means;
  for (const Bin& bin : bins)
    if (dot(bin.sum, bin.sum) > 0) means.emplace_back(sites_detail::normalized(bin.sum), bin.area);
  std::optional<Vec3d> best;
  double most = 0;
  for (const auto& [mean, own] : means) {
    pacer.step(means.size() / 4 + 1);
    if (axis && std::fabs(dot(mean, *axis)) > kPerpendicular) continue;
    double area = 0;
    for (const auto& [other, more] : means)
      if (std::fabs(dot(mean, other)) > kNear) area += more;
    if (area <= most) continue;
    most = area;
    best = mean;
  }
  return best;
}

/// Returns the most common direction within ten degrees of an axis, in steps of a 64th across it. This is the
/// direction of the faces, even if their edges are rounded.
Vec3d refined(const Solid& solid, std::size_t first, std::size_t end, const Vec3d& axis, Pacer& pacer) {
  constexpr int kSteps = 64, kReach = 12, kWide = 2 * kReach + 1;
  static_assert(kSteps * kPerpendicular < kReach);
  const sites_detail::Across frame = sites_detail::across(axis);
  std::array<Bin, std::size_t{kWide} * kWide> bins;
  each_normal(solid, first, end, pacer, [&](const Vec3d& n, double area) {
    const double along = dot(n, axis);
    if (std::fabs(along) <= kNear * area) return;
    const Vec3d same = along < 0 ? -1.0 * n : n;
    const auto step = [&](const Vec3d& across) {
      return kReach + static_cast<int>(std::nearbyint(kSteps * (dot(same, across) / area)));
    };
    bins[static_cast<std::size_t>(step(frame.u) * kWide + step(frame.v))].add(same, area);
  });
  const Bin& most =
      *std::max_element(bins.begin(), bins.end(), [](const Bin& a, const Bin& b) { return a.area < b.area; });
  return dot(most.sum, most.sum) > 0 ? sites_detail::normalized(most.sum) : axis;
}

Vec3d without_noise(Vec3d axis) {
  for (int k = 0; k < 3; ++k)
    if (std::fabs(axis[k]) < kNoiseOfAxes) axis[k] = 0;
  return sites_detail::normalized(axis);
}

/// The three axes as rows: the one nearest to y, the one of the others nearest to x, and the remaining one.
Matrix3 rows_of(const std::array<Vec3d, 3>& axes) {
  const auto nearest = [&](int k, int but) {
    int best = -1;
    for (int a = 0; a < 3; ++a)
      if (a != but && (best < 0 || std::fabs(axes[static_cast<std::size_t>(a)][k]) >
                                       std::fabs(axes[static_cast<std::size_t>(best)][k])))
        best = a;
    return best;
  };
  const int up = nearest(1, -1), along = nearest(0, up);
  Vec3d y = without_noise(axes[static_cast<std::size_t>(up)]);
  if (y.y < 0) y = -1.0 * y;
  Vec3d x = axes[static_cast<std::size_t>(along)];
  x = without_noise(x - dot(x, y) * y);
  if (x.x < 0) x = -1.0 * x;
  x = sites_detail::normalized(x - dot(x, y) * y);
  return {{x, y, cross(x, y)}};
}

/// The axes of the shape that triangles [first, end) enclose, if it is a wall.
std::optional<Matrix3> wall_axes(const Solid& solid, std::size_t first, std::size_t end, Pacer& pacer) {
  Directions bins;
  double all = 0;
  each_normal(solid, first, end, pacer, [&](const Vec3d& n, double area) {
    add(bins, n, area);
    all += area;
  });
  const std::optional<Vec3d> face = most_of(bins, nullptr, pacer);
  if (!face) return std::nullopt;
  const std::optional<Vec3d> side = most_of(bins, &*face, pacer);
  if (!side) return std::nullopt;
  const Vec3d a = refined(solid, first, end, *face, pacer);
  Vec3d b = refined(solid, first, end, *side, pacer);
  b = sites_detail::normalized(b - dot(a, b) * a);
  const std::array<Vec3d, 3> axes{a, b, cross(a, b)};
  double across = 0;
  each_normal(solid, first, end, pacer, [&](const Vec3d& n, double area) {
    for (const Vec3d& axis : axes)
      if (std::fabs(dot(n, axis)) > kAcross * area) across += area;
  });
  if (across < kLeastShare * all) return std::nullopt;
  return rows_of(axes);
}

}  // namespace

Masonry masonry_of(const Solid& solid, bool rubble, std::size_t most, const Execution& execution) {
  Pacer pacer(execution);
  const std::size_t parts = solid.parts.size();
  const Masonry::Frame none{rubble ? kRubble : Matrix3{}, !rubble};
  Masonry masonry;
  masonry.of_part.assign(parts, 0);
  const std::optional<Matrix3> whole = wall_axes(solid, 0, solid.triangles.size(), pacer);
  if (whole || parts < 2) {
    masonry.frames.push_back(whole ? Masonry::Frame{*whole, true} : none);
    return masonry;
  }
  std::vector<std::size_t> first(parts + 1, 0);  // triangles are grouped by part
  for (const std::uint32_t p : solid.part) {
    pacer.step();
    ++first[p + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::uint32_t> order;
  for (std::uint32_t p = 0; p < parts; ++p) {
    pacer.step();
    order.push_back(p);
  }
  sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t x, std::uint32_t y) {
    return solid.parts[x].volume != solid.parts[y].volume ? solid.parts[x].volume > solid.parts[y].volume
                                                          : x < y;
  });
  std::vector<Masonry::Frame>& frames = masonry.frames;
  const auto same = [](const Vec3d& a, const Vec3d& b) {
    return dot(a, b) > kSameAxes * length(a) * length(b);
  };
  const auto frame_of = [&](const Masonry::Frame& wanted) {
    const auto found = std::find_if(frames.begin(), frames.end(), [&](const Masonry::Frame& frame) {
      return frame.is_wall == wanted.is_wall && same(frame.axes.rows[0], wanted.axes.rows[0]) &&
             same(frame.axes.rows[1], wanted.axes.rows[1]);
    });
    return static_cast<std::size_t>(found - frames.begin());
  };
  std::size_t none_at = most;  // one frame is reserved for parts that are not walls
  for (const std::uint32_t p : order) {
    const std::optional<Matrix3> axes = wall_axes(solid, first[p], first[p + 1], pacer);
    std::size_t k = axes ? frame_of({*axes, true}) : none_at;
    const std::size_t free = none_at == most ? most - 1 : most;
    if (axes && k == frames.size() && k < free) frames.push_back({*axes, true});
    if (k >= frames.size()) {
      if (none_at == most) {
        none_at = frame_of(none);
        if (none_at == frames.size()) frames.push_back(none);
      }
      k = none_at;
    }
    masonry.of_part[p] = static_cast<std::uint8_t>(k);
  }
  return masonry;
}

}  // namespace fracture
