#include "common/hollow/double_walls.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"
#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "common/bvh/box_tree.hpp"
#include "common/hollow/rebuild.hpp"
#include "common/solid/corners.hpp"

namespace fracture {
namespace {

using hollow_detail::Run;
using Corners = std::array<Vec3d, 3>;

/// Parts with fewer triangles cannot have two sides that are both detailed.
constexpr std::size_t kLeastLeakTriangles = 64;
/// Number of triangles by which most parts are found to have no inner side, and the least share of their area that must
/// not see the outside.
constexpr std::size_t kSamples = 256;
constexpr double kLeastHidden = 0.25;

double area_of(const Corners& c) { return 0.5 * length(cross(c[1] - c[0], c[2] - c[0])); }

/// The inner side of a double wall.
struct InnerSide {
  std::uint64_t triangles = 0;
  double area = 0;            ///< m²
  Vec3d place;                ///< of its first triangle, or of its leak
  std::optional<double> rim;  ///< m, around the leak; empty: there is none
};

/// A part's triangles, for rays.
class Triangles {
 public:
  Triangles(std::vector<Corners> corners, const Execution& execution)
      : corners_(std::move(corners)), tree_(boxes_of(corners_), execution) {}

  std::size_t size() const { return corners_.size(); }
  const Corners& operator[](std::size_t t) const { return corners_[t]; }

  /// Whether the ray along the normal, from the middle of the triangle, meets no other triangle.
  bool sees_outside(std::size_t t, Pacer& pacer) const {
    const Corners& c = corners_[t];
    const Vec3d n = cross(c[1] - c[0], c[2] - c[0]);
    const double size = length(n);
    if (!(size > 0)) return false;
    const Vec3d from = (1.0 / 3) * (c[0] + c[1] + c[2]), along = (1 / size) * n;
    bool met = false;
    tree_.each_entered(
        [&](const Box& box) {
          pacer.step();
          return !met && may_meet(box, from, along);
        },
        [] {}, [&](std::uint32_t other) { met |= other != t && meets(corners_[other], from, along); });
    return !met;
  }

 private:
  static std::vector<Box> boxes_of(const std::vector<Corners>& corners) {
    std::vector<Box> boxes(corners.size());
    for (std::size_t t = 0; t < corners.size(); ++t)
      for (const Vec3d& p : corners[t]) boxes[t].add(p);
    return boxes;
  }
  /// Slab test (Kay & Kajiya 1986).
  static bool may_meet(const Box& box, const Vec3d& from, const Vec3d& along) {
    double enter = 0, leave = HUGE_VAL;
    for (int axis = 0; axis < 3; ++axis) {
      const double below = box.min[axis] - from[axis], above = box.max[axis] - from[axis];
      if (along[axis] == 0) {
        if (below > 0 || above < 0) return false;
        continue;
      }
      const double one = below / along[axis], other = above / along[axis];
      enter = std::fmax(enter, std::fmin(one, other));
      leave = std::fmin(leave, std::fmax(one, other));
    }
    return enter <= leave;
  }
  /// Möller & Trumbore 1997, "Fast, minimum storage ray/triangle intersection". Rounding matters little: single triangles
  /// decide nothing.
  static bool meets(const Corners& c, const Vec3d& from, const Vec3d& along) {
    const Vec3d ab = c[1] - c[0], ac = c[2] - c[0], p = cross(along, ac);
    const double determinant = dot(ab, p);
    if (determinant == 0) return false;
    const Vec3d to = from - c[0], q = cross(to, ab);
    const double u = dot(to, p) / determinant, v = dot(along, q) / determinant;
    return u >= 0 && v >= 0 && u + v <= 1 && dot(ac, q) / determinant > 0;
  }

  std::vector<Corners> corners_;
  BoxTree tree_;
};

/// Whether so many of the part's triangles do not see the outside that it may have an inner side.
bool may_have_inner_side(const Triangles& triangles, Pacer& pacer) {
  const std::size_t step = std::max<std::size_t>(1, triangles.size() / kSamples);
  double all = 0, hidden = 0;
  for (std::size_t t = 0; t < triangles.size(); t += step) {
    const double area = area_of(triangles[t]);
    all += area;
    if (!triangles.sees_outside(t, pacer)) hidden += area;
  }
  return hidden >= kLeastHidden * all;
}

/// The two triangles at each edge of a part.
using Pairs = std::vector<std::array<std::uint32_t, 2>>;
Pairs pairs_of(const Solid& solid, const Run& run, Pacer& pacer) {
  std::uint32_t least = kNoIndex, most = 0;
  for (std::size_t t = run.begin; t < run.end; ++t)
    for (const std::uint32_t e : solid.edges[t]) {
      least = std::min(least, e);
      most = std::max(most, e);
    }
  Pairs pairs(most - least + 1, {kNoIndex, kNoIndex});
  for (std::size_t t = run.begin; t < run.end; ++t) {
    pacer.step();
    for (const std::uint32_t e : solid.edges[t]) {
      auto& [one, other] = pairs[e - least];
      (one == kNoIndex ? one : other) = static_cast<std::uint32_t>(t - run.begin);
    }
  }
  std::erase_if(pairs, [](const auto& pair) { return pair[1] == kNoIndex; });
  return pairs;
}

/// Marks the largest region (by area) of connected triangles that have the flag. Empty if none has it.
std::vector<std::uint8_t> largest_region(const Triangles& triangles, const Pairs& pairs,
                                         const std::vector<std::uint8_t>& flag, Pacer& pacer) {
  DisjointSets sets(triangles.size());
  for (const auto& [one, other] : pairs) {
    pacer.step();
    if (flag[one] && flag[other]) sets.unite(one, other);
  }
  std::vector<double> area(triangles.size(), 0);
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    if (flag[t]) area[sets.find(t)] += area_of(triangles[t]);
  const auto largest = std::max_element(area.begin(), area.end());
  if (!(*largest > 0)) return {};
  const auto root = static_cast<std::uint32_t>(largest - area.begin());
  std::vector<std::uint8_t> is_in(triangles.size(), 0);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) is_in[t] = flag[t] && sets.find(t) == root;
  return is_in;
}

/// The rim of an inner side: its length, and its middle.
struct Rim {
  double length = 0;
  Vec3d middle;
};
Rim rim_of(const Triangles& triangles, const Solid& solid, const Run& run, const Pairs& pairs,
           const std::vector<std::uint8_t>& is_inner) {
  Rim rim;
  for (const auto& [one, other] : pairs) {
    if (is_inner[one] == is_inner[other]) continue;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t e = solid.edges[run.begin + one][k];
      const auto& others = solid.edges[run.begin + other];
      if (std::find(others.begin(), others.end(), e) == others.end()) continue;
      const Vec3d &a = triangles[one][k], &b = triangles[one][(k + 1) % 3];
      const double along = length(b - a);
      rim.length += along;
      rim.middle = rim.middle + (0.5 * along) * (a + b);
      break;
    }
  }
  if (rim.length > 0) rim.middle = (1 / rim.length) * rim.middle;
  return rim;
}

/// Finds the inner side of a part with one shell. `volume`: of the part, m³.
std::optional<InnerSide> find_leaking_side(const Solid& solid, const Run& run, double volume,
                                           const Execution& execution) {
  const std::size_t count = run.end - run.begin;
  if (count < kLeastLeakTriangles || count > kMostLeakTriangles) return std::nullopt;
  Pacer pacer(execution);
  const Triangles triangles(corners_of(solid, run.begin, run.end, execution), execution);
  if (!may_have_inner_side(triangles, pacer)) return std::nullopt;

  std::vector<std::uint8_t> flag(count, 0);
  constexpr std::size_t kOfOneThread = 1024;
  parallel_for(execution, count, kOfOneThread, [&](std::size_t begin, std::size_t end) {
    Pacer own(execution);
    for (std::size_t t = begin; t < end; ++t) flag[t] = triangles.sees_outside(t, own);
  });
  const Pairs pairs = pairs_of(solid, run, pacer);
  const std::vector<std::uint8_t> outer = largest_region(triangles, pairs, flag, pacer);
  if (outer.empty()) return std::nullopt;
  // Single triangles of the inner side look out through the leak. They belong to it, because it is around them.
  for (std::size_t t = 0; t < count; ++t) flag[t] = !outer[t];
  const std::vector<std::uint8_t> inner = largest_region(triangles, pairs, flag, pacer);
  if (inner.empty()) return std::nullopt;

  const Rim rim = rim_of(triangles, solid, run, pairs, inner);
  InnerSide side{.place = rim.middle, .rim = rim.length};
  double outer_area = 0,
         enclosed = 0;  // enclosed: by the inner side and a cone from its rim to the rim's middle
  for (std::size_t t = 0; t < count; ++t) {
    pacer.step();
    const Corners& c = triangles[t];
    if (!inner[t]) {
      outer_area += area_of(c);
      continue;
    }
    ++side.triangles;
    side.area += area_of(c);
    enclosed -= dot(c[0] - rim.middle, cross(c[1] - rim.middle, c[2] - rim.middle)) / 6;
  }
  const bool is_leak = rim.length > 0 &&
                       rim.length * rim.length <= 4 * std::numbers::pi * kWidestLeak * side.area &&
                       side.area >= kLeastInnerArea * outer_area && enclosed > volume;
  return is_leak ? std::optional(side) : std::nullopt;
}

std::string place(const Vec3d& p) {
  return "(" + short_number(p.x) + ", " + short_number(p.y) + ", " + short_number(p.z) + ")";
}

std::string in_words(const InnerSide& side, double thickness, double longest, std::uint64_t others,
                     const std::string& node) {
  std::string text = "A part" + (node.empty() ? "" : " in the node \"" + shortened(node) + "\"") +
                     " is a double wall" + (side.rim ? " with a leak" : "") + ": its inner " +
                     (side.rim ? "side" : "shell") + " (" + counted(side.triangles, "triangle", "triangles") +
                     (side.rim ? "" : ", the first at " + place(side.place)) +
                     ") follows the outer one at a mean distance of " + short_number(thickness) + " m, " +
                     short_number(100 * thickness / longest) + " % of the part's length.";
  if (side.rim)
    text += " The only opening between the two sides is at " + place(side.place) + " and measures " +
            short_number(*side.rim) + " m around.";
  text += " So the fragments are shards of a thin wall. If the part should be solid, " +
          std::string(side.rim ? "close the opening and delete the inner side" : "delete the inner shell") +
          " in a modelling tool.";
  if (others > 0)
    text += " " + counted(others, "further part is a double wall.", "further parts are double walls.");
  return text;
}

}  // namespace

void warn_of_double_walls(Solid& solid, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<double> area(solid.report.shells, 0);
  std::vector<std::uint64_t> triangles(solid.report.shells, 0);
  std::vector<std::uint32_t> first(solid.report.shells, kNoIndex);
  std::vector<char> has_source(solid.report.shells, 0);  // if not, `thickness` made the shell
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    pacer.step();
    const auto& c = solid.triangles[t];
    const std::uint32_t s = solid.shell[t];
    area[s] += area_of({to_double(solid.positions[c[0]]), to_double(solid.positions[c[1]]),
                        to_double(solid.positions[c[2]])});
    ++triangles[s];
    first[s] = std::min(first[s], static_cast<std::uint32_t>(t));
    has_source[s] = has_source[s] != 0 || solid.wedges[t][0] != kNoIndex;
  }
  const std::vector<Run> runs = hollow_detail::runs_of_parts(solid);
  std::uint64_t found = 0;
  std::optional<InnerSide> shown;
  double thickness_shown = 0;
  std::size_t part_shown = 0;
  for (std::size_t p = 0; p < solid.parts.size(); ++p) {
    pacer.step();
    const Part& part = solid.parts[p];
    const double outer = area[part.shells[0]];
    double inner = 0;
    std::uint32_t largest = part.shells[0];
    for (std::size_t k = 1; k < part.shells.size(); ++k) {
      const std::uint32_t s = part.shells[k];
      inner += area[s];
      if (k == 1 || area[s] > area[largest]) largest = s;
    }
    if (std::any_of(part.shells.begin(), part.shells.end(), [&](std::uint32_t s) { return !has_source[s]; }))
      continue;
    const double thickness = 2 * part.volume / (outer + inner);
    if (!(thickness <= kThinWall * part.box.longest_side())) continue;
    std::optional<InnerSide> side;
    if (inner >= kLeastInnerArea * outer)
      side = InnerSide{triangles[largest], area[largest],
                       to_double(solid.positions[solid.triangles[first[largest]][0]]), std::nullopt};
    else if (part.shells.size() == 1)
      side = find_leaking_side(solid, runs[p], part.volume, execution);
    if (!side || found++ > 0) continue;
    shown = side;
    thickness_shown = thickness;
    part_shown = p;
  }
  if (!shown) return;
  const Part& part = solid.parts[part_shown];
  const bool has_name = solid.source && part.node < solid.source->node_names.size();
  solid.report.remarks.warn(in_words(*shown, thickness_shown, part.box.longest_side(), found - 1,
                                     has_name ? solid.source->node_names[part.node] : std::string()));
}

}  // namespace fracture
