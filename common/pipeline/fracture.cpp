#include "common/pipeline/fracture.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <utility>

#include "common/physics/aggregate_hulls.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/pipeline/aggregate.hpp"
#include "common/pipeline/barycentric.hpp"
#include "common/pipeline/enough_sites.hpp"
#include "common/pipeline/fracture_steps.hpp"
#include "common/pipeline/lloyd.hpp"
#include "common/pipeline/make_report.hpp"
#include "common/pipeline/rough_cells.hpp"
#include "common/pipeline/soundness.hpp"
#include "common/solid/image.hpp"
#include "common/structure/hierarchy.hpp"

namespace fracture {
namespace {

/// The group of each site, from those of the input points; empty when each is for itself.
std::vector<std::uint32_t> groups_of_sites(const Tetrahedralization& t,
                                           const std::vector<std::uint32_t>& groups_of_input) {
  if (groups_of_input.empty()) return {};
  std::vector<const std::uint32_t*> given(t.site_count(), nullptr);
  for (std::size_t k = groups_of_input.size(); k-- > 0;)  // the first of merged points decides
    if (t.site_of_input[k] != kNoSite) given[t.site_of_input[k]] = &groups_of_input[k];
  std::map<std::uint32_t, SiteId> first;  // per given group: its lowest site
  std::vector<std::uint32_t> groups(t.site_count());
  for (const SiteId s : ids<SiteId>(t.site_count()))
    groups[s] = given[s] ? first.emplace(*given[s], s).first->second : s;
  return groups;
}

/// Whatever the groups of these cells (none: each for itself), they stay together.
void join(std::uint32_t sites, const std::vector<SiteId>& kept, std::vector<std::uint32_t>& groups) {
  if (kept.size() < 2) return;
  if (groups.empty()) {
    groups.resize(sites);
    std::iota(groups.begin(), groups.end(), 0u);
  }
  std::set<std::uint32_t> joined;
  for (const SiteId s : kept) joined.insert(groups[s]);
  for (std::uint32_t& g : groups)
    if (joined.contains(g)) g = *joined.begin();
}

/// Aggregates are those of the pattern alone: what no hit is near to stays what it was.
Expected<SplitFigures> aggregate_before_hits(const SeenSolid& seen, const FractureParameters& parameters,
                                             SitePlan& plan, const Execution& execution) {
  const Allowance::Temporary temporary(execution.allowance);
  Expected<Tetrahedralization> t = tetrahedralize(plan.points, seen.seen().box, execution);
  if (!t) return tl::unexpected(t.error());
  Diagram before{.sites = std::move(plan.points), .map = plan.map, .tetrahedralization = std::move(*t)};
  if (parameters.max_volume > 0) {
    Expected<SplitFigures> split =
        split_large(seen, before, parameters.max_volume, parameters.seed, execution);
    if (!split) return tl::unexpected(split.error());
    before.split = *split;
  }
  canonicalize(before.tetrahedralization, execution);
  const Tetrahedralization& all = before.tetrahedralization;
  const VoronoiDiagram voronoi(all, seen.seen().box, before.map, execution);
  const std::vector<std::uint32_t> groups =
      aggregate(restrict_to_solid(seen, voronoi, execution), parameters, execution);
  std::uint32_t next = all.site_count();  // more than there are groups
  for (const SiteId s : all.site_of_input) plan.groups.push_back(s == kNoSite ? next++ : groups[s]);
  plan.points = std::move(before.sites);
  return before.split;
}

}  // namespace

Expected<Diagram> make_diagram(const Solid& solid, const FractureParameters& parameters,
                               const Execution& execution, StageTimings& timings) {
  return stage(timings, execution, Stage::kTetrahedralize, [&]() -> Expected<Diagram> {
    const Expected<CellMap> map = map_of_cells(solid, parameters, execution);
    if (!map) return tl::unexpected(map.error());
    const SeenSolid seen(solid, *map, execution);
    Expected<SitePlan> plan = plan_enough_sites(seen, parameters, execution);
    if (!plan) return tl::unexpected(plan.error());
    fill_frames(seen, *plan, execution);
    if (parameters.lloyd > 0) {
      if (!plan->groups.empty())
        return fail(
            ErrorCode::kBadParameter,
            "'lloyd' moves sites to the middle of their piece, but a piece of this pattern has several.",
            "lloyd");
      const StageProgress::Part part(execution.within, 0.9);
      if (auto relaxed = relax(seen, *plan, parameters.lloyd, execution); !relaxed)
        return tl::unexpected(relaxed.error());
    }
    const bool aggregated = is_aggregated(parameters);
    Diagram diagram;
    if (!parameters.hits.empty()) {
      if (aggregated) {
        const Expected<SplitFigures> split = aggregate_before_hits(seen, parameters, *plan, execution);
        if (!split) return tl::unexpected(split.error());
        diagram.split = *split;
      }
      const std::size_t of_pattern = plan->points.size();
      if (auto added = append_hits(solid, parameters, parameters.hits, 0, *plan, execution); !added)
        return tl::unexpected(added.error());
      group_hits(parameters.hits, parameters.rest, of_pattern, *plan, execution);
    }
    Expected<Tetrahedralization> t = tetrahedralize(plan->points, seen.seen().box, execution);
    if (!t) return tl::unexpected(t.error());
    diagram.sites = std::move(plan->points);
    diagram.groups = std::move(plan->groups);
    diagram.map = plan->map;
    diagram.notes = std::move(plan->notes);
    diagram.tetrahedralization = std::move(*t);
    if (parameters.max_volume > 0 && !(aggregated && !parameters.hits.empty())) {
      if (!diagram.groups.empty())
        return fail(ErrorCode::kBadParameter,
                    "'max_volume' divides cells, but a piece of this pattern is several cells.",
                    "max_volume");
      Expected<SplitFigures> split =
          split_large(seen, diagram, parameters.max_volume, parameters.seed, execution);
      if (!split) return tl::unexpected(split.error());
      diagram.split = *split;
    }
    // Where the sites of a hit change nothing, nothing has another order than without them.
    canonicalize(diagram.tetrahedralization, execution);
    return diagram;
  });
}

Expected<CutCells> cut_cells(const Solid& solid, const Diagram& diagram, const FractureParameters& parameters,
                             const Execution& execution,
                             const std::function<void(const RestrictedDiagram&)>& inspect,
                             std::optional<RoughTrace>* trace) {
  const Tetrahedralization& t = diagram.tetrahedralization;
  const SeenSolid seen(solid, diagram.map, execution);
  const VoronoiDiagram voronoi(t, seen.seen().box, diagram.map, execution);
  std::vector<SiteId> kept;
  if (parameters.keep) kept = cells_meeting(*parameters.keep, voronoi, seen.seen().box, execution);

  CutCells cut;
  cut.kept = kept.size();
  if (parameters.dual == Dual::kBarycenter) {
    if (diagram.map)
      return fail(
          ErrorCode::kBadParameter,
          "dual=barycenter knows no stretched or turned cells: leave out 'stretch', slices of several families, or bricks.",
          "dual");
    cut.barycentric =
        fracture_barycentric(solid, voronoi, parameters.pivot, parameters.drop_above, execution);
    cut.set = std::move(cut.barycentric.set);
  } else {
    RestrictedDiagram restricted = restrict_to_solid(seen, voronoi, execution);
    if (inspect) inspect(restricted);
    std::vector<std::uint32_t> groups = diagram.groups.empty() && is_aggregated(parameters)
                                            ? aggregate(restricted, parameters, execution)
                                            : groups_of_sites(t, diagram.groups);
    join(t.site_count(), kept, groups);
    const Ownership ownership = Ownership::from_groups(t.site_count(), groups, execution);
    cut.grouped = ownership.grouped;
    make_rough_fragments(
        restricted, parameters, ownership,
        [&](const FragmentSet& set) { return judge(set, solid, Promise::kPartition); }, execution, cut,
        trace);
    if (parameters.hulls == Hulls::kConvex && is_aggregated(parameters))
      cut.hulls = make_aggregate_hulls(cut.set, voronoi, parameters.most_hulls,
                                       cells_per_fragment(parameters), execution);
    execution.poll();  // a large diagram takes some time to be given back, and so does what comes below
  }
  execution.poll();
  if (cut.set.fragments.empty())
    return fail(ErrorCode::kNoFragments, cut.barycentric.dropped > 0
                                             ? "'drop_above' leaves nothing: all pieces are larger"
                                             : "none of the pieces has a volume");
  return cut;
}

/// What a hit breaks off is small beside the mean of a large thing, and is to be there all the same.
constexpr double kShareBesideHits = 0.01;

SizeLimits limits_in_force(const FractureParameters& parameters) {
  SizeLimits limits = parameters.size;
  if (parameters.hits.empty()) return limits;
  limits.min_of_mean *= kShareBesideHits;
  if (limits.fragments == 0) return limits;
  if (parameters.rest == LocalRest::kWhole) limits.fragments = 0;
  if (parameters.rest == LocalRest::kFractured)
    for (const LocalImpact& hit : parameters.hits) limits.fragments += hit.sites;
  return limits;
}

SiteNotes notes_of(const Diagram& diagram) {
  const Tetrahedralization& t = diagram.tetrahedralization;
  return {{diagram.sites.size(), t.site_count(), t.duplicates_merged, t.far_sites_dropped},
          diagram.notes,
          diagram.split};
}

Expected<FracturedSolid> complete(const Solid& solid, const SiteNotes& sites,
                                  const FractureParameters& parameters, CutCells cut,
                                  const Execution& execution) {
  execution.poll();
  execution.reaches(1);
  FracturedSolid out;
  FragmentSet& set = out.set;
  set = std::move(cut.set);
  const Promise promise = parameters.dual == Dual::kBarycenter ? Promise::kClosed : Promise::kPartition;
  if (const Verdict verdict = judge(set, solid, promise); !verdict.sound())
    return tl::unexpected(unsound(verdict, set.certificate));
  execution.poll();
  out.hierarchy = make_hierarchy(set, parameters.levels, execution);
  if (parameters.anchors.any()) out.anchored = find_anchored(set, parameters.anchors, execution);
  if (parameters.hulls == Hulls::kConvex)
    out.hulls = make_collision_hulls(set, std::move(cut.hulls), execution);
  set.certificate.sites_asked = static_cast<std::uint32_t>(sites.figures.given);
  out.report =
      make_report(solid, sites, parameters, cut, out.anchored.count, out.hulls.report(), set, execution);
  execution.poll();
  return out;
}

Expected<FracturedSolid> fracture(const Solid& solid, const Diagram& diagram,
                                  const FractureParameters& parameters, const Execution& execution,
                                  StageTimings& timings) {
  return stage(timings, execution, Stage::kClip, [&]() -> Expected<FracturedSolid> {
    Expected<CutCells> cut = cut_cells(solid, diagram, parameters, execution);
    if (!cut) return tl::unexpected(cut.error());
    return complete(solid, notes_of(diagram), parameters, std::move(*cut), execution);
  });
}

}  // namespace fracture
