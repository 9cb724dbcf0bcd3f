#include "common/pipeline/broken_solid.hpp"

#include <utility>

#include "common/base/pacer.hpp"
#include "common/physics/hull_trim.hpp"
#include "common/pipeline/instanced_bodies.hpp"
#include "common/pipeline/kept_instances.hpp"
#include "common/pipeline/part_sets.hpp"

namespace fracture {

FractureParameters before_first_hit(const Solid& solid, const FractureParameters& parameters) {
  FractureParameters before = parameters;
  before.hits.clear();
  if (parameters.hits.empty() || parameters.rest == LocalRest::kFractured) return before;
  before.pattern = PointsPattern{{solid.box.center()}};
  before.anisotropy = {};
  before.aggregation = {};
  before.lloyd = 0;
  before.density_from.clear();
  before.size = {};
  before.keep.reset();  // hits spare the region, but nothing cuts it out
  before.assigned.clear();
  before.max_volume = before.drop_above = 0;
  before.dual = Dual::kCircumcenter;
  before.parts = Parts::kApart;
  if (may_keep_instances(solid, parameters)) {
    before.parts = Parts::kInstances;
    before.sites =
        wanted_fragments(parameters);  // decides which instances are small; the pattern has a point
  }
  return before;
}

Expected<BrokenSolid> break_solid(const Solid& solid, const Diagram& diagram,
                                  const FractureParameters& parameters, const Execution& execution) {
  FractureParameters before = before_first_hit(solid, parameters);
  BrokenSolid broken;
  if (!parameters.hits.empty()) broken.rest = parameters.rest;
  // Hulls belong to the final frames of the fragments, so cut_cells() must know the pivot.
  std::vector<KeptFragment> kept;
  Expected<CutCells> cut = cut_cells(solid, diagram, before, execution, &kept);
  if (!cut) return tl::unexpected(std::move(cut.error()));
  weigh_before_hits(solid, parameters, cut->set, execution);
  Expected<InstancedBodies> instances =
      find_instanced_bodies(cut->set.fragments, solid, parameters, execution);
  if (!instances) return tl::unexpected(std::move(instances.error()));
  if (before.hulls == Hulls::kConvex) {
    share_hulls(*instances, cut->set.fragments, cut->hulls, execution);
    cut->hulls = make_collision_hulls(cut->set, std::move(cut->hulls), before.hull_limits, execution);
    trim_at_contacts(cut->set, solid, cut->hulls, execution);
    cut->hulls_are_final = true;
    separate_trimmed(*instances, cut->hulls);
  }
  separate_carriers(*instances, cut->set.fragments);
  if (parameters.keep && !before.keep) {  // all of the solid is kept until a hit breaks something off
    const bool meets = box_of(*parameters.keep).intersects(solid.box);
    cut->kept = meets ? 1 : 0;
    cut->kept_share = meets ? 1 : 0;
  }
  Certificate& c = cut->set.certificate;
  c.volume_file = 0;
  Pacer pacer(execution);
  broken.fragments.reserve(kept.size());
  for (std::size_t k = 0; k < kept.size(); ++k) {
    pacer.step(16);
    KeptFragment& fragment = kept[k];
    if (!instances->of_fragment.empty()) fragment.instance = instances->of_fragment[k];
    fragment.fragment = std::move(cut->set.fragments[k]);
    if (!cut->hulls.of_fragment.empty()) fragment.hulls = std::move(cut->hulls.of_fragment[k]);
    c.volume_file += fragment.volume_file;
    broken.surface_area += fragment.fragment.surface_area;
    broken.fragments.push_back(std::make_shared<const KeptFragment>(std::move(fragment)));
  }
  cut->set.fragments.clear();
  cut->hulls.of_fragment.clear();
  broken.cut = std::move(*cut);
  instances->of_fragment.clear();
  if (!instances->bodies.empty())
    broken.instances = std::make_shared<const InstancedBodies>(std::move(*instances));
  broken.notes = notes_of(diagram);
  broken.points = std::make_shared<const std::vector<Vec3d>>(diagram.tetrahedralization.points);
  broken.map = diagram.map;
  broken.of_pattern = diagram.of_pattern;
  broken.with_hulls = before.hulls == Hulls::kConvex;
  if (auto hit = apply_hits(solid, parameters, broken, execution); !hit)
    return tl::unexpected(std::move(hit.error()));
  return broken;
}

std::vector<std::uint32_t> instances_of(const BrokenSolid& broken, const Execution& execution) {
  std::vector<std::uint32_t> of_fragment;
  if (!broken.instances) return of_fragment;
  of_fragment.reserve(broken.fragments.size());
  Pacer pacer(execution);
  for (const SharedFragment& kept : broken.fragments) {
    pacer.step();
    of_fragment.push_back(kept->instance);
  }
  return of_fragment;
}

Expected<FracturedSolid> complete(const Solid& solid, const BrokenSolid& broken,
                                  const FractureParameters& parameters, const Execution& execution) {
  CutCells cut = broken.cut;
  Pacer pacer(execution);
  cut.instances = broken.instances ? *broken.instances : InstancedBodies{};
  cut.instances->of_fragment = instances_of(broken, execution);
  cut.set.fragments.reserve(broken.fragments.size());
  for (const SharedFragment& kept : broken.fragments) {
    pacer.step(8 + kept->fragment.indices.size() / 64);
    cut.set.fragments.push_back(kept->fragment);
    if (broken.with_hulls) cut.hulls.of_fragment.push_back(kept->hulls);
  }
  return complete(solid, broken.notes, parameters, std::move(cut), {*broken.points, broken.map}, execution);
}

}  // namespace fracture
