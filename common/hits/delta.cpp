#include "common/hits/delta.hpp"

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "common/base/heap_bytes.hpp"
#include "common/base/pacer.hpp"
#include "common/hits/difference.hpp"
#include "common/physics/principal_axes.hpp"
#include "common/pipeline/fracture_steps.hpp"
#include "common/pipeline/instanced_bodies.hpp"
#include "common/structure/contact_bonds.hpp"
#include "common/structure/whole_bonds.hpp"

namespace fracture {
namespace {

/// Whether the new hits continue the answer: hits that leave the rest whole do not continue one that the pattern broke.
bool continues(const FracturedBase& base, const FractureParameters& parameters, const NewHits& new_hits) {
  return base.broken.hits + new_hits.count == parameters.hits.size() && base.broken.rest == parameters.rest;
}

KeptAnswer answer_of(FracturedSolid fractured, BrokenSolid broken, bool local) {
  KeptAnswer answer{std::move(fractured), {std::move(broken)}, local};
  if (answer.fractured.rest && answer.fractured.rest->trimmed_for_filters)
    answer.base.stated_hulls = answer.fractured.hulls.of_fragment;
  return answer;
}

/// The fragments of an answer that differ from an earlier one.
struct Changes {
  Delta delta;
  std::vector<std::uint32_t> numbers;  ///< of the new and changed fragments in the answer, ascending
};

/// Two answers share the fragments that no hit has cut.
Changes changes_between(const BrokenSolid& before, const BrokenSolid& after, const Execution& execution) {
  Pacer pacer(execution);
  const auto addresses = [&](const std::vector<SharedFragment>& fragments) {
    std::vector<const KeptFragment*> all;
    all.reserve(fragments.size());
    for (const SharedFragment& kept : fragments) {
      pacer.step();
      all.push_back(kept.get());
    }
    sort_with_polls(execution, all.begin(), all.end(), std::less<>());
    return all;
  };
  const std::vector<const KeptFragment*> was = addresses(before.fragments), is = addresses(after.fragments);
  const auto contains = [](const std::vector<const KeptFragment*>& all, const KeptFragment* kept) {
    return std::binary_search(all.begin(), all.end(), kept, std::less<>());
  };
  std::vector<const KeptFragment*> gone;
  for (const SharedFragment& kept : before.fragments) {
    pacer.step(4);
    if (!contains(is, kept.get())) gone.push_back(kept.get());
  }
  std::vector<std::pair<std::uint64_t, const KeptFragment*>> earlier;
  for (const KeptFragment* kept : gone) earlier.emplace_back(kept->fragment.id, kept);
  sort_with_polls(execution, earlier.begin(), earlier.end(),
                  [](const auto& a, const auto& b) { return a.first < b.first; });
  Changes changes;
  std::vector<std::uint64_t> stay;
  for (std::uint32_t k = 0; k < after.fragments.size(); ++k) {
    pacer.step(4);
    const KeptFragment& now = *after.fragments[k];
    if (contains(was, &now)) continue;
    const std::uint64_t id = now.fragment.id;
    const auto at = std::lower_bound(earlier.begin(), earlier.end(), id,
                                     [](const auto& entry, std::uint64_t key) { return entry.first < key; });
    const bool existed = at != earlier.end() && at->first == id;
    if (existed) stay.push_back(id);
    if (existed && same_shape(at->second->fragment, now.fragment) &&
        same_hulls(at->second->hulls, now.hulls) &&
        same_sheet(at->second->fragment.sheet.get(), now.fragment.sheet.get()))
      continue;
    (existed ? changes.delta.changed : changes.delta.added).push_back(id);
    changes.numbers.push_back(k);
  }
  std::sort(stay.begin(), stay.end());
  for (const KeptFragment* kept : gone)
    if (!std::binary_search(stay.begin(), stay.end(), kept->fragment.id))
      changes.delta.gone.push_back(kept->fragment.id);
  return changes;
}

/// How the whole answer rests, with the filters of the new and changed fragments. Linear in the fragments, and in what
/// find_overlaps() is, unless no two fragments can overlap.
Rest rest_of_changed(const Solid& solid, const BrokenSolid& broken, const Changes& changes,
                     const FractureParameters& parameters, const Execution& execution) {
  Pacer pacer(execution);
  Bodies bodies;
  for (const SharedFragment& kept : broken.fragments) {
    pacer.step();
    bodies.fragments.push_back(&kept->fragment);
    bodies.hulls.push_back(&kept->hulls);
  }
  Rest rest = find_rest(bodies, cells_of_bodies(parameters, broken.map, broken.cut.set.certificate.islands),
                        rest_tolerance(solid), parameters.filters, execution);
  keep_rest_of(rest, changes.numbers, changes.delta);
  return rest;
}

/// Computes the report's figures over all fragments.
CutCells::Whole figures_of(const BrokenSolid& broken, const Execution& execution) {
  CutCells::Whole whole;
  Pacer pacer(execution);
  for (const SharedFragment& kept : broken.fragments) {
    pacer.step(8);
    whole.volumes.push_back(body_volume(kept->fragment));
    whole.triangles += kept->fragment.indices.size() / 3;
    whole.nodes.push_back(kept->fragment.node);
    whole.hulls.hulls += static_cast<std::uint32_t>(kept->hulls.hulls.size());
    whole.hulls.flat += kept->hulls.flat;
    whole.hulls.simplified += kept->hulls.simplified;
    whole.hulls.excess = std::max(whole.hulls.excess, kept->hulls.excess);
  }
  sort_with_polls(execution, whole.volumes.begin(), whole.volumes.end());
  if (broken.instances) whole.instances = count_instances(*broken.instances, instances_of(broken, execution));
  return whole;
}

std::vector<const Fragment*> fragments_of(const BrokenSolid& broken) {
  std::vector<const Fragment*> fragments;
  fragments.reserve(broken.fragments.size());
  for (const SharedFragment& kept : broken.fragments) fragments.push_back(&kept->fragment);
  return fragments;
}

/// Bonds with at least one new or changed fragment, by caps, by contacts of parts, or by both.
std::vector<Bond> changed_bonds(const Solid& solid, const BrokenSolid& broken,
                                const std::vector<char>& wanted, const FractureParameters& parameters,
                                const Execution& execution) {
  Pacer pacer(execution);
  std::vector<Bond> bonds;
  for (const Bond& bond : broken.cut.set.bonds) {
    pacer.step();
    if (wanted[bond.a] || wanted[bond.b]) bonds.push_back(bond);
  }
  if (std::find(wanted.begin(), wanted.end(), 1) == wanted.end() || !parts_hold_together(solid)) return bonds;
  const std::vector<const Fragment*> fragments = fragments_of(broken);
  const CellSites cells{*broken.points, broken.map};
  return with_contact_bonds(
      bonds,
      find_contact_bonds({solid, cells, broken.cut.set.lattice_step, parameters.contact_strength}, fragments,
                         wanted, execution),
      execution);
}

/// Bonds of the wanted fragments with nodes that are not fractured. `index`: per fragment, its index in the result.
std::vector<WholeBond> changed_whole_bonds(const Solid& solid, const BrokenSolid& broken,
                                           const std::vector<char>& wanted,
                                           const std::vector<std::uint32_t>& index,
                                           const FractureParameters& parameters, const Execution& execution) {
  const bool any = std::find(wanted.begin(), wanted.end(), 1) != wanted.end();
  if (!any || !solid.scenery || is_barycentric(parameters)) return {};
  std::vector<WholeBond> bonds =
      find_whole_bonds(solid, {*broken.points, broken.map}, broken.cut.set.lattice_step,
                       parameters.contact_strength, fragments_of(broken), wanted, execution);
  for (WholeBond& bond : bonds) bond.fragment = index[bond.fragment];
  return bonds;
}

/// Completes an answer that contains only the new and changed fragments. Returns nothing if hulls far away change too.
Expected<std::optional<FracturedSolid>> only_changed(const Solid& solid, const BrokenSolid& broken,
                                                     const Changes& changes,
                                                     const FractureParameters& parameters,
                                                     const Execution& execution) {
  Pacer pacer(execution);
  const std::size_t count = broken.fragments.size();
  CutCells cut = broken.cut;
  cut.whole = figures_of(broken, execution);
  cut.instances.emplace();  // a hit cuts the instances that it reaches
  if (parameters.hulls == Hulls::kConvex) {
    cut.whole->rest = rest_of_changed(solid, broken, changes, parameters, execution);
    if (cut.whole->rest->trimmed_for_filters) return std::nullopt;
  }
  std::vector<char> wanted(count, 0);
  std::vector<std::uint32_t> index(count, kNoIndex);  // in the result
  std::uint32_t next = 0;
  for (const std::uint32_t k : changes.numbers) {
    pacer.step(64);
    wanted[k] = 1;
    index[k] = next++;
    cut.set.fragments.push_back(broken.fragments[k]->fragment);
    if (broken.with_hulls) cut.hulls.of_fragment.push_back(broken.fragments[k]->hulls);
  }
  Delta delta = changes.delta;
  cut.set.bonds = changed_bonds(solid, broken, wanted, parameters, execution);
  std::vector<char> met(count, 0);
  for (const Bond& bond : cut.set.bonds) met[bond.a] = met[bond.b] = 1;
  for (std::uint32_t k = 0; k < count; ++k) {
    pacer.step();
    if (!met[k] || wanted[k]) continue;
    index[k] = next++;
    delta.neighbors.push_back(broken.fragments[k]->fragment.id);
  }
  for (Bond& bond : cut.set.bonds) {
    bond.a = index[bond.a];
    bond.b = index[bond.b];
  }
  point_upwards(cut.set.bonds, execution);
  std::vector<WholeBond> whole_bonds =
      changed_whole_bonds(solid, broken, wanted, index, parameters, execution);
  Expected<FracturedSolid> completed =
      complete(solid, broken.notes, parameters, std::move(cut), {*broken.points, broken.map}, execution);
  if (!completed) return tl::unexpected(std::move(completed.error()));
  completed->whole_bonds = std::move(whole_bonds);
  completed->delta = std::move(delta);
  return std::move(*completed);
}

}  // namespace

std::size_t memory_size(const FracturedBase& base) {
  const BrokenSolid& broken = base.broken;
  std::size_t bytes =
      sizeof base + heap(broken.fragments) + heap(broken.cut.set.bonds) + heap(broken.notes.point_of_site);
  if (broken.points) bytes += heap(*broken.points);
  for (const SharedFragment& kept : broken.fragments) bytes += memory_size(*kept);
  if (broken.instances) {
    const InstancedBodies& instances = *broken.instances;
    bytes += sizeof instances + heap(instances.numbers) + heap(instances.bodies);
    for (const Fragment& shape : instances.shapes) bytes += memory_size(shape);
    for (const FragmentHulls& hulls : instances.hulls) bytes += memory_size(hulls);
  }
  for (const FragmentHulls& hulls : base.stated_hulls) bytes += memory_size(hulls);
  return bytes;
}

Expected<KeptAnswer> fracture_and_keep(const Solid& solid, const FractureParameters& parameters,
                                       const Execution& execution, StageTimings& timings) {
  const Expected<Diagram> diagram = make_diagram(solid, parameters, execution, timings);
  if (!diagram) return tl::unexpected(diagram.error());
  return fracture_and_keep(solid, *diagram, parameters, execution, timings);
}

Expected<KeptAnswer> fracture_and_keep(const Solid& solid, const Diagram& diagram,
                                       const FractureParameters& parameters, const Execution& execution,
                                       StageTimings& timings) {
  return stage(timings, execution, Stage::kClip, [&]() -> Expected<KeptAnswer> {
    Expected<BrokenSolid> broken = break_solid(solid, diagram, parameters, execution);
    if (!broken) return tl::unexpected(std::move(broken.error()));
    Expected<FracturedSolid> completed = complete(solid, *broken, parameters, execution);
    if (!completed) return tl::unexpected(std::move(completed.error()));
    return answer_of(std::move(*completed), std::move(*broken), false);
  });
}

FractureParameters before_hits(FractureParameters parameters, std::uint32_t new_hits) {
  parameters.hits.resize(parameters.hits.size() - new_hits);
  if (is_barycentric(
          parameters)) {  // hits of whole parts may have groups of cells, but barycentric cells have none
    parameters.aggregation = {};
    for (AssignedParts& entry : parameters.assigned) {
      FractureParameters breaks = *entry.breaks;
      breaks.aggregation = {};
      entry.breaks = std::make_shared<const FractureParameters>(std::move(breaks));
    }
  }
  return parameters;
}

Expected<KeptAnswer> fracture_delta(const Solid& solid, const FracturedBase& base,
                                    const FractureParameters& parameters, const NewHits& new_hits,
                                    const Execution& execution, StageTimings& timings) {
  if (!continues(base, parameters, new_hits)) {
    Expected<KeptAnswer> whole = fracture_and_keep(solid, parameters, execution, timings);
    if (!whole) return whole;
    return stage(timings, execution, Stage::kClip, [&]() -> Expected<KeptAnswer> {
      whole->fractured.delta = difference(base, whole->fractured, execution);
      if (new_hits.only_changed) keep_changed(whole->fractured, execution);
      return std::move(*whole);
    });
  }
  return stage(timings, execution, Stage::kClip, [&]() -> Expected<KeptAnswer> {
    BrokenSolid broken = base.broken;
    if (auto hit = apply_hits(solid, parameters, broken, execution); !hit)
      return tl::unexpected(std::move(hit.error()));
    Changes changes = changes_between(base.broken, broken, execution);
    const bool as_stated =
        base.stated_hulls.empty();  // unchanged fragments have the hulls that the answer stated
    // The strength of a bond follows the materials of both fragments, so with assigned parts both must be there.
    if (new_hits.only_changed && as_stated && parameters.assigned.empty()) {
      auto part = only_changed(solid, broken, changes, parameters, execution);
      if (!part) return tl::unexpected(std::move(part.error()));
      if (*part) return answer_of(std::move(**part), std::move(broken), true);
    }
    Expected<FracturedSolid> completed = complete(solid, broken, parameters, execution);
    if (!completed) return tl::unexpected(std::move(completed.error()));
    KeptAnswer answer = answer_of(std::move(*completed), std::move(broken), true);
    answer.fractured.delta = as_stated && answer.base.stated_hulls.empty()
                                 ? std::move(changes.delta)
                                 : difference(base, answer.fractured, execution);
    if (new_hits.only_changed) keep_changed(answer.fractured, execution);
    return answer;
  });
}

}  // namespace fracture
