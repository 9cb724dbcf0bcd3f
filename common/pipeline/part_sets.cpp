#include "common/pipeline/part_sets.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/words.hpp"
#include "common/fragment/carried_sheets.hpp"
#include "common/fragment/make_fragments.hpp"
#include "common/pipeline/kept_instances.hpp"
#include "common/pipeline/overlaps.hpp"
#include "common/pipeline/set_pieces.hpp"
#include "common/solid/part_solid.hpp"
#include "common/solid/sheet_surface.hpp"

namespace fracture {
namespace {

/// Shares a number among sets: each gets `least`, then the next one goes to the set with the most volume for each (D'Hondt 1882;
/// ties: the lowest set).
std::vector<std::uint32_t> shared(std::uint32_t number, const std::vector<double>& volumes,
                                  std::vector<std::uint32_t> least, Pacer& pacer) {
  std::uint64_t given = 0;
  for (const std::uint32_t n : least) given += n;
  for (; given < number; ++given) {
    pacer.step(volumes.size());
    std::size_t next = 0;
    for (std::size_t k = 1; k < volumes.size(); ++k)
      if (volumes[k] / (least[k] + 1) > volumes[next] / (least[next] + 1)) next = k;
    ++least[next];
  }
  return least;
}

/// The least number of fragments of a set: one for each part, or for each group of parts that hold together and each instance that
/// stays whole.
std::uint32_t least_fragments(const PartSet& set, const Execution& execution) {
  if (set.parameters.parts != Parts::kTogether) return static_cast<std::uint32_t>(set.own->parts.size());
  const PartGroups groups =
      group_parts(*set.own, set.parameters, wanted_fragments(set.parameters), execution);
  return 1 + *std::max_element(groups.of_part.begin(), groups.of_part.end());
}

/// Shares what holds for the whole among the sets.
void share(const Solid& whole, const FractureParameters& asked, std::vector<PartSet>& sets,
           const Execution& execution) {
  Pacer pacer(execution);
  std::vector<double> volumes;
  std::vector<std::uint32_t> least;
  for (const PartSet& set : sets) {
    volumes.push_back(set.own->report.volume);
    least.push_back(least_fragments(set, execution));
  }
  const std::vector<std::uint32_t> ones(sets.size(), 1);
  const SizeLimits& limits = asked.size;
  const bool same = limits.fragments == asked.sites;
  const std::vector<std::uint32_t> fragments = shared(limits.fragments, volumes, least, pacer),
                                   sites = same ? fragments : shared(asked.sites, volumes, ones, pacer),
                                   most = shared(limits.max_fragments, volumes, least, pacer);
  for (std::size_t k = 0; k < sets.size(); ++k) {
    FractureParameters& p = sets[k].parameters;
    if (!std::holds_alternative<PointsPattern>(p.pattern)) p.sites = sites[k];
    if (limits.fragments > 0) p.size.fragments = fragments[k];
    if (limits.max_fragments > 0) p.size.max_fragments = most[k];
    if (limits.max_triangles > 0) {
      const double part = static_cast<double>(sets[k].own->triangles.size()) /
                          static_cast<double>(std::max<std::size_t>(whole.triangles.size(), 1));
      p.size.max_triangles = std::max<std::uint64_t>(
          1, static_cast<std::uint64_t>(part * static_cast<double>(limits.max_triangles)));
    }
    // A fraction of the whole is the same volume for each set.
    p.size.min_volume = std::max(limits.min_volume, limits.min_fraction * whole.report.volume);
    p.size.min_fraction = 0;
  }
}

std::vector<PartSelector> selectors_of(const FractureParameters& parameters) {
  std::vector<PartSelector> selectors;
  for (const AssignedParts& entry : parameters.assigned) selectors.push_back(entry.selector);
  return selectors;
}

double distance(const Box& box, const Vec3d& p) {
  double square = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double beyond = std::fmax(std::fmax(box.min[axis] - p[axis], p[axis] - box.max[axis]), 0);
    square += beyond * beyond;
  }
  return std::sqrt(square);
}

/// The box of the parts that a set has.
Box box_of(const PartSet& set, const Solid& solid) {
  Box box;
  for (const std::uint32_t p : set.parts) box.add(solid.parts[p].box);
  return box;
}

/// The sets that have parts. Nothing is shared among them yet. `near`: leaves out the sets whose boxes it does not reach, unless
/// there is only one set; null: all.
std::vector<PartSet> divided(const Solid& solid, const FractureParameters& parameters,
                             const LocalImpact* near, const Execution& execution) {
  const PartChoice choice = choose_assigned(solid, parameters, execution);
  std::vector<std::vector<std::uint32_t>> parts(parameters.assigned.size() + 1);
  Pacer pacer(execution);
  for (std::uint32_t p = 0; p < choice.of_part.size(); ++p) {
    pacer.step();
    parts[choice.of_part[p] == kNoIndex ? 0 : choice.of_part[p] + 1].push_back(p);
  }
  std::vector<PartSet> sets;
  for (std::uint32_t k = 0; k < parts.size(); ++k)
    if (!parts[k].empty())
      sets.push_back({std::move(parts[k]), {}, parameters_of_entry(parameters, k == 0 ? kNoIndex : k - 1)});
  if (sets.size() == 1) {
    sets[0].parts.clear();
    return sets;
  }
  if (near)
    std::erase_if(
        sets, [&](const PartSet& set) { return distance(box_of(set, solid), near->point) > near->radius; });
  for (PartSet& set : sets) set.own = solid_of_parts(solid, set.parts, execution);
  return sets;
}

/// Gives each connected sheet to the set of the part that is nearest to it.
void share_sheets(const Solid& whole, std::vector<PartSet>& sets, const Execution& execution) {
  if (!whole.sheets || whole.sheets->whole) return;
  Pacer pacer(execution);
  std::vector<std::uint32_t> set_of_part(whole.parts.size(), 0);
  for (std::uint32_t k = 0; k < sets.size(); ++k)
    for (const std::uint32_t part : sets[k].parts) set_of_part[part] = k;
  const std::vector<std::uint32_t> nearest = parts_near_sheets(whole, *whole.sheets->surface, execution);
  std::vector<std::vector<std::uint32_t>> triangles(sets.size());
  for (std::size_t t = 0; t < nearest.size(); ++t) {
    pacer.step();
    triangles[set_of_part[nearest[t]]].push_back(whole.sheets->triangles[t]);
  }
  for (std::size_t k = 0; k < sets.size(); ++k)
    if (!triangles[k].empty())
      sets[k].own->sheets = make_sheets(whole.source, triangles[k], sets[k].own->box, false, execution);
}

}  // namespace

PartChoice choose_assigned(const Solid& solid, const FractureParameters& parameters,
                           const Execution& execution) {
  return choose_parts(solid, selectors_of(parameters), execution);
}

std::vector<std::string> warnings_of_assigned(const Solid& solid, const FractureParameters& parameters,
                                              const PartChoice& choice) {
  return warnings_of(solid, selectors_of(parameters), choice);
}

FractureParameters parameters_of_entry(const FractureParameters& parameters, std::uint32_t entry) {
  FractureParameters p = parameters;
  p.assigned.clear();
  if (entry != kNoIndex) take_entry(p, *parameters.assigned[entry].breaks);
  return p;
}

void take_entry(FractureParameters& parameters, const FractureParameters& breaks) {
  parameters.pattern = breaks.pattern;
  parameters.lloyd = breaks.lloyd;
  parameters.anisotropy = breaks.anisotropy;
  parameters.aggregation = breaks.aggregation;
  parameters.density_from = breaks.density_from;
  parameters.roughness = breaks.roughness;
  parameters.size.min_of_mean = breaks.size.min_of_mean;
  if (const auto* points = std::get_if<PointsPattern>(&parameters.pattern))
    parameters.sites = static_cast<std::uint32_t>(points->points.size());
}

FractureParameters reported_parameters(const FractureParameters& parameters) {
  FractureParameters reported = parameters;
  for (const AssignedParts& entry : parameters.assigned)
    if (entry.breaks->roughness.amplitude > reported.roughness.amplitude)
      reported.roughness = entry.breaks->roughness;
  return reported;
}

std::vector<PartSet> part_sets(const Solid& solid, const FractureParameters& parameters,
                               const Execution& execution) {
  std::vector<PartSet> sets = divided(solid, parameters, nullptr, execution);
  if (sets.size() == 1) return sets;
  keep_instances_in(sets, solid, parameters, execution);
  share(solid, parameters, sets, execution);
  share_sheets(solid, sets, execution);
  return sets;
}

std::vector<PartSet> sets_near_hit(const Solid& solid, const FractureParameters& parameters,
                                   const LocalImpact& hit, const Execution& execution) {
  if (parameters.assigned.empty()) return {{{}, {}, parameters}};
  std::vector<PartSet> sets = divided(solid, parameters, &hit, execution);
  for (PartSet& set : sets)
    if (set.own) set.own->box = solid.box;
  if (sets.empty()) sets.push_back({{}, {}, parameters_of_entry(parameters, kNoIndex)});
  return sets;
}

Expected<Diagram> diagram_of_sets(const Solid& solid, const FractureParameters& parameters,
                                  const Execution& execution) {
  Execution silent = execution;  // the caller reports the stage
  if (!execution.within) silent.progress = {};
  StageTimings timings;
  const auto make = [&](const Solid& own, const FractureParameters& p) {
    return make_diagram(own, p, silent, timings);
  };
  const std::vector<PartSet> sets = part_sets(solid, parameters, execution);
  if (sets.size() == 1) return make(solid, sets[0].parameters);
  Diagram whole;
  Tetrahedralization& t = whole.tetrahedralization;
  std::vector<std::uint32_t> set_of_part(solid.parts.size(), 0), in_set(solid.parts.size(), 0);
  std::vector<CellMap> maps;
  for (std::uint32_t k = 0; k < sets.size(); ++k) {
    const PartSet& set = sets[k];
    const StageProgress::Part part(execution.within,
                                   static_cast<double>(k + 1) / static_cast<double>(sets.size()));
    Expected<Diagram> made = make(*set.own, set.parameters);
    if (!made) return made;
    for (std::uint32_t p = 0; p < set.parts.size(); ++p) {
      set_of_part[set.parts[p]] = k;
      in_set[set.parts[p]] = p;
    }
    const Tetrahedralization& own = made->tetrahedralization;
    const auto first = static_cast<std::uint32_t>(t.points.size());
    whole.sites.insert(whole.sites.end(), made->sites.begin(), made->sites.end());
    t.points.insert(t.points.end(), own.points.begin(), own.points.end() - 4);  // without the corners
    for (const SiteId s : own.site_of_input) t.site_of_input.push_back(s == kNoSite ? s : SiteId{s + first});
    t.duplicates_merged += own.duplicates_merged;
    t.far_sites_dropped += own.far_sites_dropped;
    whole.remarks.add(made->remarks);
    whole.split.sites_added += made->split.sites_added;
    whole.split.passes = std::max(whole.split.passes, made->split.passes);
    whole.split.too_large += made->split.too_large;
    maps.push_back(made->map);
    whole.sets.push_back(std::move(*made));
  }
  if (whole.sites.size() > parameters.most_sites)
    return fail(ErrorCode::kTooComplex,
                "The parts of all materials together have " + grouped(whole.sites.size()) + " sites; " +
                    site_limit(parameters.most_sites) + ". Ask for fewer fragments.",
                "sites");
  t.points.resize(t.points.size() + 4);  // the corners, which nothing reads
  whole.map = CellMap::joined(maps, set_of_part, in_set);
  return whole;
}

Expected<CutCells> cut_sets(
    const Solid& solid, const Diagram& diagram, const std::vector<PartSet>& sets, const Execution& execution,
    const std::function<Expected<CutCells>(const Solid&, const Diagram&, const FractureParameters&)>& cut) {
  if (sets.size() != diagram.sets.size())
    throw InternalError("a diagram of " + std::to_string(diagram.sets.size()) + " sets for " +
                        std::to_string(sets.size()));
  SetPieces pieces(execution);
  std::uint32_t first_site = 0;
  for (std::size_t k = 0; k < sets.size(); ++k) {
    const StageProgress::Part part(execution.within,
                                   static_cast<double>(k + 1) / static_cast<double>(sets.size()));
    Expected<CutCells> made = cut(*sets[k].own, diagram.sets[k], sets[k].parameters);
    if (!made) return made;
    pieces.add_set(std::move(*made), sets[k].parts, first_site);
    first_site += diagram.sets[k].tetrahedralization.site_count();
  }
  return pieces.finish(solid);
}

void weigh_assigned(const Solid& solid, const FractureParameters& parameters, const PartChoice& choice,
                    bool together, FragmentSet& set, std::vector<WholeBond>& whole_bonds,
                    const Execution& execution) {
  Pacer pacer(execution);
  const auto entry_of = [&](std::uint32_t part) -> const AssignedParts* {
    const std::uint32_t k = choice.of_part[part];
    return k == kNoIndex ? nullptr : &parameters.assigned[k];
  };
  const auto density = [&](std::uint32_t part) { return entry_of(part) ? entry_of(part)->density : 1; };
  const auto strength = [&](std::uint32_t fragment) {
    const AssignedParts* const entry = entry_of(set.fragments[fragment].part);
    return entry ? entry->strength : 1;
  };
  if (!is_barycentric(parameters)) {
    // The weighed volume is a sum over parts, because hits do not change parts.
    const std::vector<double> shares = together ? density_shares(solid, execution) : std::vector<double>();
    set.weighed_volume = 0;
    for (std::uint32_t p = 0; p < solid.parts.size(); ++p) {
      pacer.step();
      set.weighed_volume += density(p) * (shares.empty() ? 1 : shares[p]) * solid.parts[p].volume;
    }
  }
  for (Bond& bond : set.bonds) {
    pacer.step();
    bond.strength *= std::min(strength(bond.a), strength(bond.b));
  }
  for (WholeBond& bond : whole_bonds) {
    pacer.step();
    bond.strength *= std::min(strength(bond.fragment), 1.0);
  }
  for (Fragment& f : set.fragments) {
    pacer.step();
    f.density_share *= density(f.part);
  }
}

void weigh_before_hits(const Solid& solid, const FractureParameters& parameters, FragmentSet& set,
                       const Execution& execution) {
  if (!is_barycentric(parameters)) return;
  set.weighed_volume = set.certificate.volume_out;
  if (parameters.assigned.empty()) return;
  const PartChoice choice = choose_assigned(solid, parameters, execution);
  set.weighed_volume = 0;
  Pacer pacer(execution);
  for (const Fragment& f : set.fragments) {
    pacer.step();
    const std::uint32_t k = choice.of_part[f.part];
    set.weighed_volume += (k == kNoIndex ? 1 : parameters.assigned[k].density) * f.mass.volume;
  }
}

}  // namespace fracture
