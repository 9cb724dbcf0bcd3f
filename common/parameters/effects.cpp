#include "common/parameters/effects.hpp"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/words.hpp"
#include "common/mesh/mesh.hpp"
#include "common/parameters/rows.hpp"

namespace fracture {
namespace {

/// Why a parameter had no effect and what to do, after "'name' had no effect: ". None: it had an effect.
using Why = std::optional<std::string>;

struct Asked {
  const RequestParameters& request;
  const FracturedSolid& answer;
  const FractureParameters& fracture = request.fracture;
  const SitePattern& pattern = request.fracture.pattern;
};

struct Check {
  const char* parameter;
  Why (*why)(const Asked&);
};

std::string pattern_in(const Asked& a) {
  return std::string("pattern=") + kPatternTraits[a.pattern.index()].name;
}

Why needs_hits(const Asked& a) {
  if (!a.request.local_point.empty()) return {};
  return "it applies only to hits. Give 'local_point' and 'local_radius'.";
}
Why needs_fragment(const Asked& a) {
  if (a.request.fragment) return {};
  return "it applies only if a fragment breaks again. Give 'fragment'.";
}
Why needs_roughness(const Asked& a) {
  if (a.fracture.roughness.amplitude > 0) return {};
  return "the cuts are flat. Give 'rough_amplitude'.";
}
Why needs_hulls(const Asked& a) {
  if (a.request.physics != Physics::kNone || a.request.ue_collision != UeCollision::kNone) return {};
  return "physics=none makes no collision hulls. Choose another 'physics'.";
}
Why needs_parts(const Asked& a) {
  if (a.answer.report.solid.parts > 1) return {};
  return "the mesh has only one part, so it has no contacts between parts.";
}

/// Fragments also have bonds with nodes that stay whole.
Why needs_contacts(const Asked& a) {
  const std::shared_ptr<const Mesh>& source = a.answer.set.source;
  return source && source->passed_through ? Why{} : needs_parts(a);
}

Why instances(const Asked& a) {
  if (a.fracture.parts == Parts::kApart)
    return "with parts=apart, each fragment belongs to one part. Use parts=together.";
  std::vector<std::uint32_t> meshes;
  if (a.answer.set.source)
    for (const MeshInstance& node : a.answer.set.source->instances)
      if (node.mesh != kNoIndex) meshes.push_back(node.mesh);
  std::sort(meshes.begin(), meshes.end());
  if (std::adjacent_find(meshes.begin(), meshes.end()) != meshes.end()) return {};
  return "no two nodes of the file have the same mesh, so the file has no instances.";
}

Why needs_stretch(const Asked& a) {
  if (a.fracture.anisotropy.stretch != 1) return {};
  return "pieces are as long as they are wide. Give a 'stretch' other than 1.";
}

Why grain(const Asked& a) {
  if (!a.fracture.anisotropy.grain) return {};  // another parameter has replaced that of the material
  return needs_stretch(a);
}

Why grain_of(const Asked& a) {
  if (a.fracture.anisotropy.matrix) return {};  // it has replaced that of the material
  if (!is_scattered(a.pattern))
    return pattern_in(a) + " has one grain for the whole mesh. Use pattern=uniform, impact or clustered.";
  return needs_stretch(a);
}

Why cells_per_fragment_of(const Asked& a) {
  if (!a.request.idle_aggregation) return {};
  return "with dual=barycenter, each fragment is one cell. Leave out either this or 'dual'.";
}

Why size_spread(const Asked& a) {
  if (const Why why = cells_per_fragment_of(a)) return why;
  if (cells_per_fragment(a.fracture) > 1) return {};
  return "each fragment is one cell. Give 'cells_per_fragment'.";
}

Why seed(const Asked& a) {
  if (a.fracture.roughness.amplitude > 0 || !a.fracture.hits.empty() || a.request.fragment) return {};
  const auto* grid = std::get_if<GridPattern>(&a.pattern);
  if (!std::holds_alternative<PointsPattern>(a.pattern) && !(grid && grid->jitter == 0)) return {};
  return pattern_in(a) + " uses no random numbers" + (grid ? " without 'jitter'." : ".");
}

Why axis(const Asked& a) {
  const auto* radial = std::get_if<RadialPattern>(&a.pattern);
  if (!radial || radial->around != RadialPattern::Around::kPoint) return {};
  return "with around=point, spokes run in all directions. Use around=axis.";
}

Why tilt(const Asked& a) {
  const auto* slices = std::get_if<SlicePattern>(&a.pattern);
  if (!slices || slices->normals.size() < 2) return {};
  return "planes are tilted only if there is a single family. Give a single vector in 'normals'.";
}

Why mortar(const Asked& a) {
  if (a.fracture.dual == Dual::kCircumcenter) return {};
  return "dual=barycenter makes no joints. Leave out 'dual'.";
}

/// The radius and the exponent of impacts or clusters without sites.
Why near_sites(const Asked& a) {
  const auto* impact = std::get_if<ImpactPattern>(&a.pattern);
  const auto* clustered = std::get_if<ClusteredPattern>(&a.pattern);
  if ((!impact || impact->share > 0) && (!clustered || clustered->share > 0)) return {};
  return "'share' is 0, so no sites are near impacts or in clusters. Give a 'share' above 0.";
}

Why impacts(const Asked& a) {
  const auto* radial = std::get_if<RadialPattern>(&a.pattern);
  if (!radial || radial->impacts.size() < 2 || a.answer.report.solid.parts > 1) return {};
  return "pattern=radial has one centre. For several points, use pattern=impact.";
}

Why dual(const Asked& a) {
  if (a.fracture.dual == Dual::kCircumcenter || is_barycentric(a.fracture)) return {};
  return "with local_rest=whole, hits cut the unbroken parts into Voronoi cells. Use local_rest=fractured, or leave "
         "out 'dual'.";
}

Why min_of_mean(const Asked& a) {
  // It merges the pieces of hits.
  if (!is_barycentric(a.fracture) || !a.fracture.hits.empty() || !(a.fracture.size.min_of_mean > 0))
    return {};
  return "fragments of dual=barycenter are not merged by size, because they share no cuts. Leave out either "
         "this or 'dual'.";
}

Why drop_above(const Asked& a) {
  if (dual(a))
    return "with local_rest=whole, hits cut the unbroken parts into Voronoi cells. Use local_rest=fractured, or leave "
           "out both this and 'dual'.";
  const auto& barycenter = a.answer.report.barycenter;
  if (!barycenter || !barycenter->dropped || barycenter->dropped->fragments > 0) return {};
  return "no fragment is larger than this volume. Give a smaller one.";
}

Why shell_ball(const Asked& a) {
  // 'shell' and 'shell_fraction' set it to 0.
  if (a.request.hollow.any() || !(a.request.hollow.least_ball > 0)) return {};
  return "nothing becomes hollow. Give 'shell' or 'shell_fraction'.";
}

Why gravity(const Asked& a) {
  if (a.fracture.anchors.any()) return {};
  return "it applies only to the support analysis, which needs anchors. Give 'anchor_plane', 'anchor_box' or "
         "'anchor_points'.";
}

Why broken(const Asked& a) {
  if (!a.answer.support || a.answer.support->unknown == 0) return {};
  std::vector<std::uint64_t> ids;
  for (const Fragment& f : a.answer.set.fragments) ids.push_back(f.id);
  std::sort(ids.begin(), ids.end());
  std::string unknown;
  constexpr std::size_t kMostNamed = 5;
  std::size_t count = 0;
  for (const std::uint64_t id : a.request.broken) {
    if (std::binary_search(ids.begin(), ids.end(), id) || ++count > kMostNamed) continue;
    unknown += (unknown.empty() ? "" : ", ") + std::to_string(id);
  }
  if (count > kMostNamed) unknown += " and " + grouped(count - kMostNamed) + " more";
  return "no fragment has the ID " + unknown + ". Use IDs from the answer to this request without 'broken'.";
}

constexpr Check kChecks[] = {
    {"seed", seed},
    {"grain", grain},
    {"grain_of", grain_of},
    {"cells_per_fragment", cells_per_fragment_of},
    {"size_spread", size_spread},
    {"impacts", impacts},
    {"radius", near_sites},
    {"exponent", near_sites},
    {"axis", axis},
    {"mortar", mortar},
    {"tilt", tilt},
    {"parts", needs_parts},
    {"instances", instances},
    {"contact_gap", needs_contacts},
    {"contact_strength", needs_contacts},
    {"gravity", gravity},
    {"broken", broken},
    {"local_sites", needs_hits},
    {"local_rest", needs_hits},
    {"fragment_sites", needs_fragment},
    {"fragment_seed", needs_fragment},
    {"rough_frequency", needs_roughness},
    {"rough_octaves", needs_roughness},
    {"shell_ball", shell_ball},
    {"dual", dual},
    {"drop_above", drop_above},
    {"min_of_mean", min_of_mean},
    {"max_hulls", needs_hulls},
    {"hull_excess", needs_hulls},
};

nlohmann::json value_of(const ParameterSpec& row, const RequestParameters& parameters) {
  return belongs(row, parameters.fracture.pattern) ? row.get(parameters, row) : nlohmann::json();
}

}  // namespace

bool has_effect_check(std::string_view parameter) {
  return std::any_of(std::begin(kChecks), std::end(kChecks),
                     [&](const Check& check) { return check.parameter == parameter; });
}

std::vector<std::string> parameters_without_effect(const RequestParameters& parameters,
                                                   const FracturedSolid& answer) {
  static const std::vector<ParameterSpec> rows = parameter_rows(1, FormatSet());
  const RequestParameters baseline = baseline_of(parameters);
  std::vector<std::string> sentences;
  for (const Check& check : kChecks) {
    const auto row = std::find_if(rows.begin(), rows.end(),
                                  [&](const ParameterSpec& spec) { return spec.name == check.parameter; });
    if (value_of(*row, parameters) == value_of(*row, baseline)) continue;
    if (const Why why = check.why({parameters, answer}))
      sentences.push_back(
          "'" + row->name +
          (row->name == "impacts" ? "' had no effect beyond its first point: " : "' had no effect: ") + *why);
  }
  return sentences;
}

}  // namespace fracture
