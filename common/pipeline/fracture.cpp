#include "common/pipeline/fracture.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/fragment/carried_sheets.hpp"
#include "common/physics/aggregate_hulls.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/physics/hull_trim.hpp"
#include "common/pipeline/aggregate.hpp"
#include "common/pipeline/barycentric.hpp"
#include "common/pipeline/broken_solid.hpp"
#include "common/pipeline/cell_groups.hpp"
#include "common/pipeline/enough_sites.hpp"
#include "common/pipeline/fracture_steps.hpp"
#include "common/pipeline/instanced_bodies.hpp"
#include "common/pipeline/intact.hpp"
#include "common/pipeline/keep_sites.hpp"
#include "common/pipeline/lloyd.hpp"
#include "common/pipeline/make_report.hpp"
#include "common/pipeline/overlaps.hpp"
#include "common/pipeline/part_sets.hpp"
#include "common/pipeline/rough_cells.hpp"
#include "common/pipeline/soundness.hpp"
#include "common/sites/request_places.hpp"
#include "common/solid/image.hpp"
#include "common/structure/contact_bonds.hpp"
#include "common/structure/hierarchy.hpp"

namespace fracture {
namespace {

/// For each site, the brick to which its cell belongs. If points were merged, the first one decides.
std::vector<std::uint32_t> bricks_of_sites(const Tetrahedralization& t,
                                           const std::vector<std::uint32_t>& bricks_of_input,
                                           const Execution& execution) {
  if (bricks_of_input.empty()) return {};
  std::vector<std::uint32_t> bricks(t.site_count(), kNoIndex);
  Pacer pacer(execution);
  for (std::size_t k = bricks_of_input.size(); k-- > 0;) {
    pacer.step();
    if (const SiteId s = t.site_of_input[k]; s != kNoSite) bricks[s] = bricks_of_input[k];
  }
  return bricks;
}

/// Share of the volume that fragments with one of these cells have. `kept`: ascending.
double share_of(const std::vector<SiteId>& kept, const FragmentSet& set) {
  double volume = 0;
  for (const Fragment& f : set.fragments)
    if (std::any_of(f.sites.begin(), f.sites.end(),
                    [&](SiteId s) { return std::binary_search(kept.begin(), kept.end(), s); }))
      volume += f.mass.volume;
  return set.certificate.volume_in > 0 ? volume / set.certificate.volume_in : 0;
}

}  // namespace

Expected<Diagram> make_diagram(const Solid& solid, const FractureParameters& given,
                               const Execution& execution, StageTimings& timings) {
  return stage(timings, execution, Stage::kTetrahedralize, [&]() -> Expected<Diagram> {
    FractureParameters parameters = before_first_hit(solid, given);
    if (!parameters.assigned.empty()) {
      Expected<Diagram> of_sets = diagram_of_sets(solid, parameters, execution);
      if (!of_sets) return of_sets;
      of_sets->of_pattern = of_sets->sites.size();
      if (auto few = check_sites_of_hits(given, given.hits, of_sets->of_pattern); !few)
        return tl::unexpected(few.error());
      return of_sets;
    }
    Remarks remarks;
    put_impacts_on(solid, parameters.pattern, remarks, execution);
    Expected<CellMap> map = map_of_cells(solid, parameters, execution);
    if (!map) return tl::unexpected(map.error());
    // Barycentric cells do not support frames, and a kept region needs a single diagram. So all parts share one.
    if (std::holds_alternative<RadialPattern>(parameters.pattern) && map->frames().size() > 1 &&
        (parameters.dual == Dual::kBarycenter || parameters.keep))
      map = CellMap();
    const SeenSolid seen(solid, *map, execution);
    Expected<SitePlan> plan = plan_enough_sites(seen, parameters, execution);
    if (!plan) return tl::unexpected(plan.error());
    fill_frames(seen, *plan, execution);
    if (parameters.lloyd > 0) {
      if (!plan->groups.empty())
        return fail(
            ErrorCode::kBadParameter,
            "'lloyd' moves each site to the middle of its piece, but pieces of this pattern have several sites. Leave 'lloyd' out.",
            "lloyd");
      const StageProgress::Part part(execution.within, 0.9);
      if (auto relaxed = relax(seen, *plan, parameters.lloyd, execution); !relaxed)
        return tl::unexpected(relaxed.error());
    }
    Diagram diagram;
    if (parameters.max_volume > 0 && !plan->groups.empty())
      return fail(ErrorCode::kBadParameter,
                  "'max_volume' divides cells, but pieces of this pattern have several cells. Leave it out.",
                  "max_volume");
    diagram.of_pattern = plan->points.size();
    if (auto few = check_sites_of_hits(given, given.hits, diagram.of_pattern); !few)
      return tl::unexpected(few.error());
    if (parameters.keep && parameters.dual == Dual::kCircumcenter)
      add_keep_sites(KeptSpace(*parameters.keep, seen), seen,
                     !is_aggregated(parameters) && !(parameters.max_volume > 0),
                     std::holds_alternative<PointsPattern>(parameters.pattern), *plan, execution);
    Expected<Tetrahedralization> t = tetrahedralize(plan->points, seen.seen().box, execution);
    if (!t) return tl::unexpected(t.error());
    diagram.sites = std::move(plan->points);
    diagram.groups = std::move(plan->groups);
    diagram.bricks = std::move(plan->bricks);
    diagram.map = plan->map;
    diagram.clearance = plan->clearance;
    // With LocalRest::kWhole, the only point is not one of the request.
    if (given.hits.empty() || given.rest == LocalRest::kFractured) remarks.add(plan->remarks);
    diagram.remarks = std::move(remarks);
    const std::span<const Vec3d> impacts = impacts_of(parameters.pattern);
    diagram.impacts.assign(impacts.begin(), impacts.end());
    diagram.tetrahedralization = std::move(*t);
    if (parameters.max_volume > 0) {
      Expected<SplitFigures> split = split_large(seen, diagram, parameters, execution);
      if (!split) return tl::unexpected(split.error());
      diagram.split = *split;
    }
    canonicalize(diagram.tetrahedralization, execution);
    return diagram;
  });
}

Expected<CutCells> cut_cells(const Solid& solid, const Diagram& diagram, const FractureParameters& given,
                             const Execution& execution, std::vector<KeptFragment>* kept) {
  if (!given.assigned.empty()) {
    const std::vector<PartSet> sets = part_sets(solid, given, execution);
    if (sets.size() == 1) return cut_cells(solid, diagram, sets[0].parameters, execution, kept);
    return cut_sets(solid, diagram, sets, execution,
                    [&](const Solid& own, const Diagram& of_set, const FractureParameters& p) {
                      std::vector<KeptFragment> of_own;
                      Expected<CutCells> cut = cut_cells(own, of_set, p, execution, kept ? &of_own : nullptr);
                      if (kept) std::move(of_own.begin(), of_own.end(), std::back_inserter(*kept));
                      return cut;
                    });
  }
  FractureParameters parameters = given;
  if (kept) parameters.pivot = Pivot::kSource;
  const auto keep = [&](FragmentSet& set) {
    if (!kept) return;
    kept->resize(set.fragments.size());
    parallel_for(execution, kept->size(), 8, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        (*kept)[k] = kept_with_pivot(std::move(set.fragments[k]), given.pivot, execution);
        set.fragments[k] = std::move((*kept)[k].fragment);
      }
    });
  };
  const Tetrahedralization& t = diagram.tetrahedralization;
  const SeenSolid seen(solid, diagram.map, execution);
  const VoronoiDiagram voronoi(t, seen.seen().box, diagram.map, execution);
  const std::vector<SiteId> kept_together = kept_cells(seen, voronoi, parameters, execution);
  CutCells cut;
  cut.kept = kept_together.size();
  if (parameters.dual == Dual::kBarycenter) {
    if (diagram.map)
      return fail(
          ErrorCode::kBadParameter,
          "dual=barycenter does not work with stretched or rotated cells: leave out 'stretch', slices of several families, or bricks.",
          "dual");
    cut.barycentric =
        fracture_barycentric(solid, voronoi, parameters.pivot, parameters.drop_above, execution);
    cut.set = std::move(cut.barycentric.set);
    cut.grouped = !diagram.groups.empty();
    keep(cut.set);
  } else {
    RestrictedDiagram restricted = restrict_to_solid(seen, voronoi, execution);
    const std::vector<std::uint32_t> bricks = bricks_of_sites(t, diagram.bricks, execution);
    restricted.bricks = bricks;
    std::vector<std::uint32_t> groups =
        diagram.groups.empty() && is_aggregated(parameters)
            ? aggregate(restricted, parameters, diagram.impacts, kept_together, execution)
            : groups_of_sites(t, diagram.groups, execution);
    keep_together(t.site_count(), kept_together, groups);
    const Ownership ownership = Ownership::from_groups(t.site_count(), groups, execution);
    cut.grouped = ownership.grouped;
    SizeLimits limits = parameters.size;
    limits.weights = weights_of_parts(solid, parameters, diagram.impacts, execution);
    if (!kept_together.empty()) limits.kept_owner = ownership.owner_of_site[kept_together[0]];
    const Restraints flat = flat_near_kept(seen, voronoi, parameters, kept_together, execution);
    make_rough_fragments(
        restricted, parameters, std::move(limits), ownership, flat, {},
        [&](const FragmentSet& set) { return judge(set, solid, Promise::kPartition); }, execution, cut);
    cut.kept_share = share_of(kept_together, cut.set);
    keep(cut.set);
    if (parameters.hulls == Hulls::kConvex)
      cut.hulls =
          make_aggregate_hulls(cut.set, voronoi, parameters.hull_limits, cells_per_fragment(parameters),
                               parameters.keep.has_value(), execution);
    execution.poll();  // freeing a large diagram takes some time, and so do the steps below
  }
  execution.poll();
  if (cut.set.fragments.empty())
    return fail(
        ErrorCode::kNoFragments,
        cut.barycentric.dropped > 0
            ? "'drop_above' removes all pieces, because all are larger than this limit. Raise 'drop_above'."
            : "No piece has a volume.");
  carry_sheets(solid, voronoi, seen.seen().box, cut.set, execution);
  return cut;
}

SiteNotes notes_of(const Diagram& diagram) {
  const Tetrahedralization& t = diagram.tetrahedralization;
  SiteNotes notes{{diagram.sites.size(), t.site_count(), t.duplicates_merged, t.far_sites_dropped},
                  diagram.remarks,
                  diagram.split};
  if (t.site_count() < diagram.sites.size()) {
    notes.point_of_site.assign(t.site_count(), kNoIndex);
    for (std::size_t k = t.site_of_input.size(); k-- > 0;)
      if (const SiteId s = t.site_of_input[k]; s != kNoSite)
        notes.point_of_site[s] = static_cast<std::uint32_t>(k);
  }
  return notes;
}

Expected<FracturedSolid> complete(const Solid& solid, const SiteNotes& sites,
                                  const FractureParameters& parameters, CutCells cut, const CellSites& cells,
                                  const Execution& execution) {
  execution.poll();
  execution.reaches(1);
  FracturedSolid out;
  FragmentSet& set = out.set;
  set = std::move(cut.set);
  if (solid.sheets && solid.sheets->whole) {
    set.whole_sheets = solid.sheets;
    set.certificate.sheet_area_in = set.certificate.sheet_area_out = solid.sheets->area;
  }
  const Promise promise = is_barycentric(parameters) ? Promise::kClosed : Promise::kPartition;
  if (const Verdict verdict = judge(set, solid, promise); !verdict.sound())
    return tl::unexpected(unsound(verdict, set.certificate));
  execution.poll();
  const bool together = parameters.parts == Parts::kTogether && promise == Promise::kPartition;
  count_overlaps_once(solid, together, set, execution);
  if (promise == Promise::kPartition) set.weighed_volume = set.certificate.volume_once;
  if (promise == Promise::kPartition && !cut.whole && cut.touch_across)
    add_contact_bonds(set, solid, cells, parameters.contact_strength, execution);
  if (promise == Promise::kPartition && !cut.whole && solid.scenery) {
    std::vector<const Fragment*> fragments;
    for (const Fragment& f : set.fragments) fragments.push_back(&f);
    out.whole_bonds = find_whole_bonds(solid, cells, set.lattice_step, parameters.contact_strength, fragments,
                                       {}, execution);
  }
  std::vector<std::string> warnings;
  if (!parameters.assigned.empty()) {
    const PartChoice choice = choose_assigned(solid, parameters, execution);
    weigh_assigned(solid, parameters, choice, together, set, out.whole_bonds, execution);
    warnings = warnings_of_assigned(solid, parameters, choice);
  }
  out.hierarchy = make_hierarchy(set, parameters.levels, execution);
  if (parameters.anchors.any())
    out.anchored = find_anchored(set, parameters.anchors, solid.box.longest_side(), execution);
  if (cut.instances) {
    out.instances = std::move(*cut.instances);
  } else {
    Expected<InstancedBodies> instances = find_instanced_bodies(set.fragments, solid, parameters, execution);
    if (!instances) return tl::unexpected(std::move(instances.error()));
    out.instances = std::move(*instances);
  }
  if (parameters.hulls == Hulls::kConvex) {
    if (!cut.hulls_are_final) share_hulls(out.instances, set.fragments, cut.hulls, execution);
    out.hulls = cut.hulls_are_final
                    ? std::move(cut.hulls)
                    : make_collision_hulls(set, std::move(cut.hulls), parameters.hull_limits, execution);
    trim_at_contacts(set, solid, out.hulls, execution);
    out.rest = cut.whole ? std::move(cut.whole->rest)
                         : bring_to_rest(set, out.hulls,
                                         cells_of_bodies(parameters, cells.map, set.certificate.islands),
                                         rest_tolerance(solid), parameters.filters, execution);
    separate_trimmed(out.instances, out.hulls);
    if (const Verdict verdict = judge_rest(out.rest.value(), parameters.filters); !verdict.sound())
      return tl::unexpected(unsound(verdict, set.certificate));
  }
  separate_carriers(out.instances, set.fragments);
  if (parameters.intact) {
    Expected<IntactSolid> intact = make_intact(solid, parameters, execution);
    if (!intact) return tl::unexpected(intact.error());
    out.intact = std::move(*intact);
  }
  set.certificate.sites_asked = static_cast<std::uint32_t>(sites.figures.given);
  const std::optional<std::uint32_t> anchored =
      parameters.anchors.any() && !cut.whole ? std::optional(out.anchored.count) : std::nullopt;
  out.point_of_site = sites.point_of_site;
  out.report = make_report(solid, sites, reported_parameters(parameters), cut, anchored, out.hulls.report(),
                           out.rest, set, execution);
  out.report.instances =
      cut.whole ? cut.whole->instances : count_instances(out.instances, out.instances.of_fragment);
  for (std::string& warning : warnings) out.report.remarks.warn(std::move(warning));
  if (out.intact)
    for (const std::string& warning : out.intact->warnings) out.report.remarks.warn(warning);
  execution.poll();
  return out;
}

Expected<FracturedSolid> fracture(const Solid& solid, const Diagram& diagram,
                                  const FractureParameters& parameters, const Execution& execution,
                                  StageTimings& timings) {
  return stage(timings, execution, Stage::kClip, [&]() -> Expected<FracturedSolid> {
    // With assigned parts, the certificate then has the same sums as one that is kept for hits.
    if (!parameters.hits.empty() || !parameters.assigned.empty()) {
      Expected<BrokenSolid> broken = break_solid(solid, diagram, parameters, execution);
      if (!broken) return tl::unexpected(std::move(broken.error()));
      return complete(solid, *broken, parameters, execution);
    }
    Expected<CutCells> cut = cut_cells(solid, diagram, parameters, execution);
    if (!cut) return tl::unexpected(cut.error());
    weigh_before_hits(solid, parameters, cut->set, execution);
    return complete(solid, notes_of(diagram), parameters, std::move(*cut),
                    {diagram.tetrahedralization.points, diagram.map}, execution);
  });
}

}  // namespace fracture
