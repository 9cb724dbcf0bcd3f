#include "common/pipeline/fracture.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "common/fragment/fragment_mesh.hpp"
#include "common/fragment/make_fragments.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/pipeline/barycentric.hpp"
#include "common/pipeline/fracture_steps.hpp"
#include "common/pipeline/lloyd.hpp"
#include "common/pipeline/restrict.hpp"
#include "common/rough/roughen.hpp"
#include "common/solid/image.hpp"
#include "common/structure/hierarchy.hpp"

namespace fracture {
namespace {

nlohmann::json report_of(const Solid& solid, const Diagram& diagram, const FragmentSet& set) {
  nlohmann::json warnings = nlohmann::json::array();
  for (const std::string& w : solid.source->warnings) warnings.push_back(w);
  for (const std::string& note : solid.report.notes) warnings.push_back(note);
  for (const std::string& note : diagram.notes) warnings.push_back(note);
  if (set.lattice_ratio > 1e-5)
    warnings.push_back(
        "the mesh lies so far from the origin that float32 positions are coarse: one step is more than 1e-5 "
        "of its size");
  const Tetrahedralization& t = diagram.tetrahedralization;
  return {{"solid", solid.report.to_json()},
          {"sites",
           {{"given", diagram.sites.size()},
            {"used", t.site_count()},
            {"duplicates_merged", t.duplicates_merged},
            {"far_dropped", t.far_sites_dropped}}},
          {"warnings", std::move(warnings)}};
}

/// The group of each site, from those of the input points and the cells that stay together whatever their
/// groups; empty when each is for itself.
std::vector<std::uint32_t> groups_of_sites(const Tetrahedralization& t,
                                           const std::vector<std::uint32_t>& groups_of_input,
                                           const std::vector<SiteId>& kept) {
  if (groups_of_input.empty() && kept.size() < 2) return {};
  std::vector<const std::uint32_t*> given(t.site_count(), nullptr);
  for (std::size_t k = groups_of_input.size(); k-- > 0;)  // the first of merged points decides
    if (t.site_of_input[k] != kNoSite) given[t.site_of_input[k]] = &groups_of_input[k];
  std::map<std::uint32_t, SiteId> first;  // per given group: its lowest site
  std::vector<std::uint32_t> groups(t.site_count());
  for (SiteId s = 0; s < t.site_count(); ++s)
    groups[s] = given[s] ? first.emplace(*given[s], s).first->second : s;
  if (kept.size() < 2) return groups;
  std::set<std::uint32_t> joined;
  for (const SiteId s : kept) joined.insert(groups[s]);
  for (std::uint32_t& g : groups)
    if (joined.contains(g)) g = *joined.begin();
  return groups;
}

std::string text_of(double value) { return nlohmann::json(value).dump(); }

/// How the volumes of the fragments are distributed, m³. The coefficient of variation is the standard
/// deviation over the mean: 0 is all alike.
nlohmann::json volume_distribution(const std::vector<Fragment>& fragments) {
  std::vector<double> volumes;
  for (const Fragment& f : fragments) volumes.push_back(f.mass.volume);
  std::sort(volumes.begin(), volumes.end());
  const std::size_t n = volumes.size();
  if (n == 0) return nlohmann::json::object();
  const auto quantile = [&](std::size_t tenths) { return volumes[(n - 1) * tenths / 10]; };
  double sum = 0, squares = 0, in_largest_tenth = 0;
  for (const double v : volumes) sum += v;
  const double mean = sum / static_cast<double>(n);
  for (const double v : volumes) squares += (v - mean) * (v - mean);
  const std::size_t tenth = (n + 9) / 10;
  for (std::size_t k = n - tenth; k < n; ++k) in_largest_tenth += volumes[k];
  return {{"smallest", volumes.front()},
          {"lowest_tenth", quantile(1)},
          {"median", quantile(5)},
          {"highest_tenth", quantile(9)},
          {"largest", volumes.back()},
          {"mean", mean},
          {"coefficient_of_variation", mean > 0 ? std::sqrt(squares / static_cast<double>(n)) / mean : 0},
          {"share_of_largest_tenth", sum > 0 ? in_largest_tenth / sum : 0}};
}

/// What was asked of the sizes and the structure, and what was made.
void report_structure(const FractureParameters& p, const Diagram& diagram, std::size_t kept_cells,
                      std::uint64_t triangles, std::uint32_t anchored, FragmentSet& set) {
  double largest = 0;
  for (const Fragment& f : set.fragments) {
    largest = std::max(largest, f.mass.volume);
    triangles += f.indices.size() / 3;
  }
  nlohmann::json& warnings = set.report["warnings"];
  nlohmann::json size = volume_distribution(set.fragments);
  size["triangles"] = triangles;
  if (p.size.any()) {
    size["united"] = set.size.united;
    size["alone"] = set.size.alone;
    if (set.size.min_volume > 0) size["min_volume"] = set.size.min_volume;
    if (set.size.alone > 0)
      warnings.push_back(std::to_string(set.size.alone) + " pieces below " + text_of(set.size.min_volume) +
                         " m3 touch no other piece; they stay as they are");
  }
  if (p.size.max_fragments > 0) {
    size["max_fragments"] = p.size.max_fragments;
    if (set.fragments.size() > p.size.max_fragments)
      warnings.push_back("max_fragments: " + std::to_string(p.size.max_fragments) + " asked, " +
                         std::to_string(set.fragments.size()) +
                         " made; what is left touches nothing it could "
                         "be united with");
  }
  if (p.size.max_triangles > 0) {
    size["max_triangles"] = p.size.max_triangles;
    size["fewest_triangles"] = set.size.fewest_triangles;
    if (triangles > p.size.max_triangles)
      warnings.push_back("max_triangles: " + std::to_string(p.size.max_triangles) + " asked, " +
                         std::to_string(triangles) + " made; uniting everything would leave " +
                         std::to_string(set.size.fewest_triangles) + ", so nothing was united for it");
  }
  if (p.max_volume > 0) {
    size["max_volume"] = p.max_volume;
    size["sites_added"] = diagram.split.sites_added;
    size["passes"] = diagram.split.passes;
    size["too_large"] = diagram.split.too_large;
    if (largest > p.max_volume)
      warnings.push_back("max_volume: " + text_of(p.max_volume) + " m3 asked, the largest fragment has " +
                         text_of(largest) + " m3 (united, kept, or the passes or sites ran out)");
  }
  set.report["size"] = std::move(size);
  if (p.keep) {
    set.report["keep"] = {{"cells", kept_cells}};
    if (kept_cells == 0) warnings.push_back("keep: the region lies outside of the mesh's box");
  }
  if (p.anchors.any()) {
    set.report["anchors"] = {{"fragments", anchored}};
    if (anchored == 0) warnings.push_back("anchors: no fragment touches one");
  }
  if (!p.levels.empty()) {
    nlohmann::json made = nlohmann::json::array();
    for (const ClusterLevel& level : set.hierarchy.levels) made.push_back(level.clusters.size());
    made.push_back(set.fragments.size());
    set.report["levels"] = std::move(made);
  }
}

/// What was asked of the cuts, and what was made.
void report_roughness(const FractureParameters& p, const RoughReport& rough, FragmentSet& set) {
  nlohmann::json& warnings = set.report["warnings"];
  if (p.dual == Dual::kBarycenter) {
    warnings.push_back("rough cuts: hulls of barycentres share no cuts; theirs are flat");
    return;
  }
  set.report["rough_cuts"] = {{"amplitude", rough.amplitude},    {"amplitude_asked", rough.asked},
                              {"edge_length", rough.length},     {"triangles", rough.triangles},
                              {"calmed_vertices", rough.calmed}, {"crossing_triangles", rough.crossing}};
  if (rough.amplitude < rough.asked)
    warnings.push_back("rough cuts: amplitude lowered from " + text_of(rough.asked) + " m to " +
                       text_of(rough.amplitude) +
                       " m, so that the cuts do not cross each other; a lower frequency allows a larger one");
  if (rough.crossing > 0)
    warnings.push_back("rough cuts: " + std::to_string(rough.crossing) +
                       " pairs of their triangles cross, as the surface itself does there");
}

}  // namespace

Expected<Diagram> make_diagram(const Solid& solid, const FractureParameters& parameters,
                               const Execution& execution, StageTimings& timings) {
  return stage(timings, execution, "tetrahedralize", [&]() -> Expected<Diagram> {
    Expected<SitePlan> plan = plan_sites(solid, parameters, execution);
    if (!plan) return tl::unexpected(plan.error());
    std::optional<Solid> image;
    if (plan->map) image = image_of(solid, *plan->map);
    const Solid& seen = image ? *image : solid;
    if (parameters.lloyd > 0) {
      if (!plan->groups.empty())
        return fail(
            ErrorCode::kBadParameter,
            "'lloyd' moves sites to the middle of their piece, but a piece of this pattern has several.",
            "lloyd");
      if (auto relaxed = relax(solid, seen, *plan, parameters.lloyd, execution); !relaxed)
        return tl::unexpected(relaxed.error());
    }
    if (!parameters.hits.empty()) {
      const std::size_t of_pattern = plan->points.size();
      if (auto added = append_hits(solid, parameters, parameters.hits, 0, *plan, execution); !added)
        return tl::unexpected(added.error());
      group_hits(parameters.hits, parameters.rest, of_pattern, *plan);
    }
    Expected<Tetrahedralization> t = tetrahedralize(plan->points, seen.box, execution);
    if (!t) return tl::unexpected(t.error());
    Diagram diagram;
    diagram.sites = std::move(plan->points);
    diagram.groups = std::move(plan->groups);
    diagram.map = plan->map;
    diagram.notes = std::move(plan->notes);
    diagram.tetrahedralization = std::move(*t);
    if (parameters.max_volume > 0) {
      if (!diagram.groups.empty())
        return fail(ErrorCode::kBadParameter,
                    "'max_volume' divides cells, but a piece of this pattern is several cells.",
                    "max_volume");
      Expected<SplitFigures> split =
          split_large(solid, seen, diagram, parameters.max_volume, parameters.seed, execution);
      if (!split) return tl::unexpected(split.error());
      diagram.split = *split;
    }
    // Where the sites of a hit change nothing, nothing has another order than without them.
    canonicalize(diagram.tetrahedralization);
    return diagram;
  });
}

namespace {

/// Fractures one fragment of the answer to these parameters again.
Expected<FragmentSet> fracture_again(const Solid& solid, const Diagram& diagram,
                                     const FractureParameters& parameters, const Execution& execution,
                                     StageTimings& timings) {
  FractureParameters before = parameters;
  before.again.reset();
  before.hulls = Hulls::kNone;
  before.pivot = Pivot::kSource;
  before.levels.clear();
  before.anchors = {};
  Expected<FragmentSet> whole = fracture(solid, diagram, before, execution, timings);
  if (!whole) return whole;
  const auto at = std::find_if(whole->fragments.begin(), whole->fragments.end(),
                               [&](const Fragment& f) { return f.id == parameters.again->fragment; });
  if (at == whole->fragments.end())
    return fail(ErrorCode::kNoSuchFragment,
                "The answer to these parameters has " + std::to_string(whole->fragments.size()) +
                    " fragments; none has the id " + std::to_string(parameters.again->fragment) +
                    ". Ids are a function of the sites: give the parameters of the answer that has it.",
                "fragment");
  auto mesh =
      std::make_shared<Mesh>(fragment_mesh(*whole, static_cast<std::size_t>(at - whole->fragments.begin())));
  Expected<Solid> fragment = make_solid(std::move(mesh), {}, execution);
  if (!fragment) return tl::unexpected(fragment.error());

  FractureParameters parts;
  parts.sites = parameters.again->sites;
  parts.seed = parameters.again->seed;
  parts.hulls = parameters.hulls;
  parts.pivot = parameters.pivot;
  parts.roughness = parameters.roughness;
  parts.levels = parameters.levels;
  parts.anchors = parameters.anchors;
  const Expected<Diagram> finer = make_diagram(*fragment, parts, execution, timings);
  if (!finer) return tl::unexpected(finer.error());
  Expected<FragmentSet> set = fracture(*fragment, *finer, parts, execution, timings);
  if (set) set->report["fragment"] = {{"id", parameters.again->fragment}, {"volume", at->mass.volume}};
  return set;
}

}  // namespace

Expected<CutCells> cut_cells(const Solid& solid, const Diagram& diagram, const FractureParameters& parameters,
                             const Execution& execution,
                             const std::function<void(const RestrictedDiagram&)>& look) {
  const Tetrahedralization& t = diagram.tetrahedralization;
  std::optional<Solid> image;
  if (diagram.map) image = image_of(solid, *diagram.map);
  const Solid& seen = image ? *image : solid;
  const VoronoiDiagram voronoi(t, seen.box, diagram.map);
  std::vector<SiteId> kept;
  if (parameters.keep) kept = cells_meeting(*parameters.keep, voronoi, seen.box);
  const Ownership ownership =
      Ownership::from_groups(t.site_count(), groups_of_sites(t, diagram.groups, kept));

  CutCells cut;
  cut.kept = kept.size();
  cut.grouped = ownership.grouped;
  if (parameters.dual == Dual::kBarycenter) {
    if (image)
      return fail(
          ErrorCode::kBadParameter,
          "dual=barycenter knows no stretched cells: leave out 'stretch', or slices of several families.",
          "dual");
    cut.barycentric =
        fracture_barycentric(solid, voronoi, parameters.pivot, parameters.drop_above, execution);
    cut.set = std::move(cut.barycentric.set);
  } else {
    RestrictedDiagram restricted = restrict_to_solid(solid, seen, voronoi, execution);
    if (look) look(restricted);
    cut.rough =
        roughen(solid, voronoi, restricted.cuts, restricted.winding, ownership.owner_of_site,
                parameters.roughness, parameters.seed, restricted.positions, restricted.caps, execution);
    cut.set = make_fragments(restricted, ownership, parameters.pivot, parameters.size, execution);
  }
  if (cut.set.fragments.empty())
    return fail(ErrorCode::kNoFragments, cut.barycentric.dropped > 0
                                             ? "'drop_above' leaves nothing: all pieces are larger"
                                             : "none of the pieces has a volume");
  return cut;
}

FragmentSet complete(const Solid& solid, const Diagram& diagram, const FractureParameters& parameters,
                     CutCells cut, const Execution& execution) {
  FragmentSet set = std::move(cut.set);
  set.hierarchy = make_hierarchy(set, parameters.levels, execution);
  std::uint32_t anchored = 0;
  if (parameters.anchors.any()) anchored = mark_anchored(set, parameters.anchors);
  HullReport hulls;
  if (parameters.hulls == Hulls::kConvex) hulls = add_collision_hulls(set, execution);
  set.certificate.sites_asked = static_cast<std::uint32_t>(diagram.sites.size());
  set.report = report_of(solid, diagram, set);
  report_structure(parameters, diagram, cut.kept, cut.further_triangles, anchored, set);
  if (parameters.roughness.amplitude > 0) report_roughness(parameters, cut.rough, set);
  if (parameters.hulls == Hulls::kConvex)
    set.report["hulls"] = {{"count", hulls.hulls + cut.further_hulls.hulls},
                           {"flat", hulls.flat + cut.further_hulls.flat},
                           {"simplified", hulls.simplified + cut.further_hulls.simplified}};
  if (parameters.dual == Dual::kBarycenter) {
    nlohmann::json& mode = set.report["barycenter"];
    mode = {{"partition", false}, {"skipped_hulls", cut.barycentric.skipped_hulls}};
    if (parameters.drop_above > 0) {
      mode["dropped"] = cut.barycentric.dropped;
      mode["dropped_volume"] = cut.barycentric.dropped_volume;
    }
    set.report["warnings"].push_back(
        "dual=barycenter: the hulls of barycentres overlap and leave gaps; volumes do not add up to the "
        "solid's, and there are no bonds");
    if (cut.grouped)
      set.report["warnings"].push_back(
          "dual=barycenter: each cell is a fragment, those that the pattern keeps together too");
  }
  return set;
}

Expected<FragmentSet> fracture(const Solid& solid, const Diagram& diagram,
                               const FractureParameters& parameters, const Execution& execution,
                               StageTimings& timings) {
  if (parameters.again) return fracture_again(solid, diagram, parameters, execution, timings);
  return stage(timings, execution, "clip", [&]() -> Expected<FragmentSet> {
    Expected<CutCells> cut = cut_cells(solid, diagram, parameters, execution);
    if (!cut) return tl::unexpected(cut.error());
    return complete(solid, diagram, parameters, std::move(*cut), execution);
  });
}

}  // namespace fracture
