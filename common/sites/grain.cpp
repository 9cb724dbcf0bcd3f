#include "common/sites/grain.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/long_axis.hpp"
#include "common/base/pacer.hpp"
#include "common/sites/arithmetic.hpp"
#include "common/sites/moments.hpp"
#include "common/solid/main_materials.hpp"

namespace fracture {
namespace {

using sites_detail::Moments;

constexpr double kSameDirection = 0.985;  // cosine of ten degrees
/// Minimum ratio of the second moments along the longest and the next axis: the ratio of a bar 1.5 times as
/// long as wide.
constexpr double kLeastElongation = 2.25;

/// The longest axis of inertia, if it is much longer than the next.
std::optional<Vec3d> axis_of(const Moments& moments) {
  if (!(moments.volume > 0)) return std::nullopt;
  const std::optional<LongAxis> longest = long_axis(moments.central());
  if (!longest || !(longest->ratio > kLeastElongation)) return std::nullopt;
  return sites_detail::without_noise(longest->axis);
}

/// Returns a number for each part. Parts get the same number if the same material covers most of their
/// surface in the source.
std::vector<std::uint32_t> numbers_of_materials(const Solid& solid, const Execution& execution) {
  const std::vector<std::uint32_t> main = main_materials(solid, execution);
  std::map<std::uint32_t, std::uint32_t> numbers;
  std::vector<std::uint32_t> number(main.size(), 0);
  for (std::size_t p = 0; p < main.size(); ++p)
    if (main[p] != kInteriorMaterial)
      number[p] = numbers.try_emplace(main[p], static_cast<std::uint32_t>(numbers.size())).first->second;
  return number;
}

}  // namespace

Grains grains_of(const Solid& solid, GrainOf of, const Vec3d& whole, std::size_t most,
                 const Execution& execution) {
  const std::size_t parts = solid.parts.size();
  Pacer pacer(execution);
  std::vector<std::uint32_t> group(parts);
  if (of == GrainOf::kMaterial) group = numbers_of_materials(solid, execution);
  std::uint32_t groups = 0;
  pacer.each(0, parts, [&](std::size_t p) {
    if (of == GrainOf::kNode) group[p] = solid.parts[p].node;
    if (of == GrainOf::kPart) group[p] = static_cast<std::uint32_t>(p);
    groups = std::max(groups, group[p] + 1);
  });
  // Moments are taken about the middle of the box of the part, or of the solid, which is near enough to keep
  // rounding errors small.
  const bool by_node = of == GrainOf::kNode;
  std::vector<Moments> of_part;
  resize_with_polls(execution, of_part, by_node ? groups : parts);
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    pacer.step(8);
    const std::uint32_t p = solid.part[t];
    const Vec3d origin = by_node ? solid.box.center() : solid.parts[p].box.center();
    const auto& [a, b, c] = solid.triangles[t];
    of_part[by_node ? group[p] : p].add(to_double(solid.positions[a]) - origin,
                                        to_double(solid.positions[b]) - origin,
                                        to_double(solid.positions[c]) - origin);
  }
  std::vector<Moments> moments;
  if (of == GrainOf::kMaterial) {
    // Take each part's moments about its own middle, so that four table legs have their own long direction
    // however far apart they are.
    resize_with_polls(execution, moments, groups);
    pacer.each(0, parts, [&](std::size_t p) {
      if (!(of_part[p].volume > 0)) return;
      Moments& together = moments[group[p]];
      together.volume += of_part[p].volume;
      const Matrix3 own = of_part[p].central();
      for (std::size_t row = 0; row < 3; ++row)
        together.second.rows[row] = together.second.rows[row] + own.rows[row];
    });
  } else {
    moments = std::move(of_part);
  }

  std::vector<std::uint32_t> order(groups);
  std::iota(order.begin(), order.end(), 0u);
  sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t x, std::uint32_t y) {
    return moments[x].volume != moments[y].volume ? moments[x].volume > moments[y].volume : x < y;
  });
  Grains grains;
  std::vector<std::uint8_t> of_group(groups, 0);
  for (const std::uint32_t g : order) {
    if (!(moments[g].volume > 0) && !grains.directions.empty()) break;  // no such part, or no volume
    pacer.step(16);
    const Vec3d direction = axis_of(moments[g]).value_or(whole);
    const auto cosine = [&](const Vec3d& other) { return std::fabs(dot(direction, other)); };
    const auto nearest =
        std::max_element(grains.directions.begin(), grains.directions.end(),
                         [&](const Vec3d& x, const Vec3d& y) { return cosine(x) < cosine(y); });
    if (nearest != grains.directions.end() &&
        (cosine(*nearest) > kSameDirection || grains.directions.size() >= most)) {
      of_group[g] = static_cast<std::uint8_t>(nearest - grains.directions.begin());
      continue;
    }
    of_group[g] = static_cast<std::uint8_t>(grains.directions.size());
    grains.directions.push_back(direction);
  }
  if (grains.directions.empty()) grains.directions.push_back(whole);
  grains.of_part.resize(parts);
  pacer.each(0, parts, [&](std::size_t p) { grains.of_part[p] = of_group[group[p]]; });
  return grains;
}

}  // namespace fracture
