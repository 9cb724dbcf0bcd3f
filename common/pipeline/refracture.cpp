#include "common/pipeline/refracture.hpp"

#include <algorithm>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "common/contacts/contacts.hpp"
#include "common/fragment/fragment_mesh.hpp"
#include "common/fragment/sheet_mesh.hpp"
#include "common/pipeline/part_sets.hpp"
#include "common/solid/sheet_surface.hpp"

namespace fracture {
namespace {

/// Makes the sheets that the fragment carries sheets of its solid.
void take_sheets(const FragmentSet& whole, const Fragment& f, Solid& fragment, const Execution& execution) {
  const auto mesh = std::make_shared<const Mesh>(mesh_of_sheet(whole, f, execution));
  std::vector<std::uint32_t> triangles(mesh->triangles.size());
  std::iota(triangles.begin(), triangles.end(), 0u);
  fragment.sheets = make_sheets(mesh, triangles, fragment.box, false, execution);
  if (!fragment.sheets) return;
  fragment.report.sheets = 1;
  fragment.report.sheet_triangles = fragment.sheets->triangles.size();
  fragment.report.sheet_area = fragment.sheets->area;
}

}  // namespace

Expected<FracturedSolid> refracture(const Solid& solid, const Diagram& diagram,
                                    const FractureParameters& parameters, const Refracture& wanted,
                                    const Execution& execution, StageTimings& timings) {
  FractureParameters before = parameters;
  before.hulls = Hulls::kNone;
  before.pivot = Pivot::kSource;
  before.levels.clear();
  before.anchors = {};
  before.intact = false;
  const Expected<FracturedSolid> fractured = [&] {
    const StageProgress::Part part(execution.within, 0.7);
    return fracture(solid, diagram, before, execution, timings);
  }();
  if (!fractured) return tl::unexpected(fractured.error());
  const FragmentSet& whole = fractured->set;
  const auto at = std::find_if(whole.fragments.begin(), whole.fragments.end(),
                               [&](const Fragment& f) { return f.id == wanted.fragment; });
  if (at == whole.fragments.end())
    return fail(
        ErrorCode::kNoSuchFragment,
        "The answer with these parameters has " + std::to_string(whole.fragments.size()) +
            " fragments, and none of them has the id " + std::to_string(wanted.fragment) +
            ". Ids depend on the sites: give the parameters of the answer that contains the fragment.",
        "fragment");
  auto mesh = std::make_shared<Mesh>(
      fragment_mesh(whole, static_cast<std::size_t>(at - whole.fragments.begin()), execution));
  Expected<Solid> fragment = make_solid(std::move(mesh), {.sheets = SheetsMode::kDrop}, execution);
  if (!fragment) return tl::unexpected(fragment.error());
  if (at->sheet) take_sheets(whole, *at, *fragment, execution);
  if (solid.contacts) keep_contacts(*fragment, solid.contacts->gap, execution);

  // The fragment breaks like its part.
  const std::uint32_t entry = parameters.assigned.empty()
                                  ? kNoIndex
                                  : choose_assigned(solid, parameters, execution).of_part[at->source_part];
  const FractureParameters of_part = parameters_of_entry(parameters, entry);
  FractureParameters parts;
  parts.sites = wanted.sites;
  parts.most_sites = parameters.most_sites;
  parts.seed = wanted.seed;
  parts.hulls = parameters.hulls;
  parts.filters = parameters.filters;
  parts.pivot = parameters.pivot;
  parts.roughness = of_part.roughness;
  parts.aggregation.cells = cells_per_fragment(of_part);
  parts.aggregation.spread = of_part.aggregation.spread;
  parts.hull_limits = parameters.hull_limits;
  parts.levels = parameters.levels;
  parts.parts = parameters.parts;
  parts.contact_strength = parameters.contact_strength;
  parts.anchors = parameters.anchors;
  parts.intact = parameters.intact;
  const Expected<Diagram> finer = make_diagram(*fragment, parts, execution, timings);
  if (!finer) return tl::unexpected(finer.error());
  Expected<FracturedSolid> made = fracture(*fragment, *finer, parts, execution, timings);
  if (!made) return made;
  made->report.fragment = {wanted.fragment, at->mass.volume};
  const auto make_share_of_fragment = [&](std::vector<Fragment>& pieces) {
    for (Fragment& f : pieces) {
      f.source_part = at->source_part;
      f.nodes = at->nodes;
      f.density_share = at->density_share;  // so that the masses add up to that of the fragment
      for (FragmentPrimitive& p : f.primitives) p.part = kNoIndex;  // its part is one of the fragment's solid
    }
  };
  make_share_of_fragment(made->set.fragments);
  if (made->intact) make_share_of_fragment(made->intact->parts);
  for (ClusterLevel& level : made->hierarchy.levels)
    for (Cluster& cluster : level.clusters) cluster.density_share = at->density_share;
  made->set.certificate.volume_once = at->density_share * made->set.certificate.volume_in;
  made->set.weighed_volume = made->set.certificate.volume_once;
  if (entry != kNoIndex) {
    made->set.certificate.volume_once /= parameters.assigned[entry].density;
    if (made->intact)
      for (Fragment& f : made->intact->parts) f.density_share *= parameters.assigned[entry].density;
    for (Bond& bond : made->set.bonds) bond.strength *= parameters.assigned[entry].strength;
    for (ClusterLevel& level : made->hierarchy.levels)
      for (Bond& bond : level.bonds) bond.strength *= parameters.assigned[entry].strength;
  }
  return made;
}

}  // namespace fracture
