#include "common/sites/density.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/base/printable.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/mesh/material_library.hpp"
#include "common/sites/generators.hpp"

namespace fracture::sites_detail {
namespace {

constexpr std::uint64_t kDensityStream = 0xde45'0000'0000'0001ull;
constexpr double kRoundingOfDistances = 1e-12;  // relative to the largest coordinate
/// Maximum number of candidates per wanted site. Even in regions of the least density, this accepts two
/// candidates per wanted site on average.
constexpr double kMostLooks = 64;

tl::unexpected<Error> unknown(
    const std::string& from, const std::string& why,
    const std::string& advice = "Use another colour set or material, or leave 'density_from' out.") {
  return fail(ErrorCode::kBadParameter,
              "'density_from': " + why + " ('" + shortened(printable(from)) + "'). " + advice,
              "density_from");
}

/// Relative luminance of linear RGB (ITU-R BT.709).
double luminance(const Vec4f& c) {
  const double y = 0.2126 * static_cast<double>(c.x) + 0.7152 * static_cast<double>(c.y) +
                   0.0722 * static_cast<double>(c.z);
  return y >= 0 ? std::fmin(y, 1) : 0;  // NaN counts as 0
}

std::array<Vec3d, 3> corners_of(const Solid& solid, std::uint32_t t) {
  const auto& [a, b, c] = solid.triangles[t];
  return {to_double(solid.positions[a]), to_double(solid.positions[b]), to_double(solid.positions[c])};
}

std::vector<Box> boxes_of(const Solid& solid, const auto& triangles, Pacer& pacer) {
  std::vector<Box> boxes;
  for (const auto& weighted : triangles) {
    pacer.step();
    boxes.push_back(box_of(corners_of(solid, weighted.triangle)));
  }
  return boxes;
}

std::uint32_t material_of(const Mesh& mesh, const std::string& wanted) {
  const nlohmann::json& materials = mesh.library->materials;
  for (std::uint32_t k = 0; k < materials.size(); ++k) {
    const auto name = materials[k].find("name");
    if (name != materials[k].end() && name->is_string() && name->get_ref<const std::string&>() == wanted)
      return k;
  }
  for (std::uint32_t k = 0; k < materials.size(); ++k)
    if (wanted == std::to_string(k)) return k;
  return kNoIndex;
}

}  // namespace

Expected<Density> Density::make(const Solid& solid, const std::string& from, const Execution& execution) {
  if (!solid.source) return unknown(from, "the solid has no source mesh");
  const Mesh& mesh = *solid.source;
  Pacer pacer(execution);
  std::vector<Weighted> triangles;
  double most = 0;
  const bool color = from.size() == 7 && from.rfind("COLOR_", 0) == 0 && from[6] >= '0' && from[6] <= '7';
  const auto set = static_cast<std::size_t>(color ? from[6] - '0' : 0);
  if (color && (set >= mesh.attributes.colors.size() || mesh.attributes.colors[set].empty()))
    return unknown(from, "the mesh has no such vertex colours",
                   "Use a colour set or a material that it has.");
  const std::uint32_t material = color ? kNoIndex : material_of(mesh, from);
  if (!color && material == kNoIndex)
    return unknown(from, "this is neither a colour set (COLOR_0 to COLOR_7) nor a material of the mesh",
                   "`fracture-server inspect --json` and GET /meshes/{id} list its materials.");
  for (std::uint32_t t = 0; t < solid.triangles.size(); ++t) {
    pacer.step(4);
    if (solid.wedges[t][0] == kNoIndex) continue;
    Weighted weighted{t, {}};
    for (std::size_t k = 0; k < 3; ++k) {
      weighted.weight[k] = color ? luminance(mesh.attributes.colors[set][solid.wedges[t][k]])
                                 : static_cast<double>(solid.material[t] == material);
      most = std::fmax(most, weighted.weight[k]);
    }
    triangles.push_back(weighted);
  }
  if (!(most > 0))
    return unknown(
        from, color ? "these vertex colours are black everywhere" : "no part of the solid has this material");
  for (Weighted& weighted : triangles) {
    pacer.step();
    for (double& weight : weighted.weight) weight = kLeast + (1 - kLeast) * (weight / most);
  }
  return Density(solid, std::move(triangles), execution);
}

Density::Density(const Solid& solid, std::vector<Weighted> triangles, const Execution& execution)
    : solid_(&solid),
      triangles_(std::move(triangles)),
      tree_(
          [&] {
            Pacer pacer(execution);
            return boxes_of(solid, triangles_, pacer);
          }(),
          execution) {
  for (int a = 0; a < 3; ++a)
    slack_ = std::fmax(slack_, std::fmax(std::fabs(solid.box.min[a]), std::fabs(solid.box.max[a])));
  slack_ *= kRoundingOfDistances;
}

double Density::at(const Vec3d& p, Pacer& pacer) const {
  double least = HUGE_VAL;
  std::uint32_t nearest = 0;
  tree_.nearest(p, HUGE_VAL, slack_, [&](std::uint32_t k) {
    pacer.step();
    const auto [a, b, c] = corners_of(*solid_, triangles_[k].triangle);
    const double distance = distance_to_triangle(p, a, b, c);
    if (distance < least || (distance == least && k < nearest)) {
      least = distance;
      nearest = k;
    }
    return distance;
  });
  // Interpolate between the corners by the areas of the triangles that p forms with the sides, ignoring sides
  // that p is beyond.
  const auto [a, b, c] = corners_of(*solid_, triangles_[nearest].triangle);
  const Vec3d n = cross(b - a, c - a);
  const std::array<double, 3> share{std::fmax(0, dot(n, cross(c - b, p - b))),
                                    std::fmax(0, dot(n, cross(a - c, p - c))),
                                    std::fmax(0, dot(n, cross(b - a, p - a)))};
  const std::array<double, 3>& weight = triangles_[nearest].weight;
  const double sum = share[0] + share[1] + share[2];
  if (!(sum > 0)) return (weight[0] + weight[1] + weight[2]) / 3;
  return (share[0] * weight[0] + share[1] * weight[1] + share[2] * weight[2]) / sum;
}

std::vector<Vec3d> even_points(const Task& task, ColumnSampler& sampler, std::uint32_t count) {
  if (!task.density) return sampler.sample(count);
  const CellMap& map = task.seen.map();
  Random seeder(task.seed ^ kDensityStream);
  const std::uint64_t stream = seeder();
  Pacer pacer(task.execution);
  std::vector<Vec3d> kept, refused;
  const double most = kMostLooks * count;
  // The candidates form a fixed sequence, and asking for more only extends it.
  std::size_t looked_at = 0;
  for (double wanted = 2.0 * count; kept.size() < count; wanted *= 2) {
    const std::vector<Vec3d> points = sampler.sample(static_cast<std::uint32_t>(std::fmin(wanted, most)));
    for (; looked_at < points.size() && kept.size() < count; ++looked_at) {
      pacer.step(16);
      const Vec3d& p = points[looked_at];
      const double weight = task.density->at(map ? map.at(p).place(p) : p, pacer);
      (Random(stream + looked_at * kGoldenGamma).uniform() < weight ? kept : refused).push_back(p);
    }
    if (wanted >= most) break;
  }
  for (std::size_t k = 0; kept.size() < count && k < refused.size(); ++k) kept.push_back(refused[k]);
  return kept;
}

}  // namespace fracture::sites_detail
