#include "common/hits/delta.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/fragment/carried_sheets.hpp"
#include "common/hits/difference.hpp"
#include "common/hits/local_hit.hpp"
#include "common/pipeline/fracture_steps.hpp"
#include "common/structure/contact_bonds.hpp"

namespace fracture {
namespace {

/// Whether hits on the answer can be local, as far as the parameters decide it.
bool may_be_local(const FractureParameters& p) {
  const bool counted = p.size.max_fragments > 0 || p.size.max_triangles > 0;
  return p.dual == Dual::kCircumcenter && !p.keep && !counted && p.max_volume == 0 && p.assigned.empty() &&
         (p.hits.empty() || p.rest == LocalRest::kFractured);
}

/// A bond with a new or changed fragment at one or both ends.
struct ChangedBond {
  PlaceInAnswer a, b;
  Bond bond;  ///< its ends are not set yet
};

const KeptFragment& kept_at(const HitOutcome& hit, const PlaceInAnswer& place) {
  return hit.next.cells[place.site]->fragments[place.fragment];
}

/// The index of a place in an ascending list; kNoIndex if it is not in the list.
std::uint32_t number_in(const std::vector<PlaceInAnswer>& places, const PlaceInAnswer& place) {
  const auto at = std::lower_bound(places.begin(), places.end(), place);
  return at != places.end() && *at == place ? static_cast<std::uint32_t>(at - places.begin()) : kNoIndex;
}

std::vector<ChangedBond> changed_cap_bonds(const HitOutcome& hit, Pacer& pacer) {
  std::vector<ChangedBond> bonds;
  for (const SiteId s : hit.around) {
    if (!hit.next.bonds[s]) continue;
    for (const KeptBond& bond : *hit.next.bonds[s]) {
      pacer.step(8);
      const PlaceInAnswer a{s, bond.fragment}, b{bond.other_cell, bond.other_fragment};
      if (number_in(hit.changed, a) != kNoIndex || number_in(hit.changed, b) != kNoIndex)
        bonds.push_back({a, b, {0, 0, bond.area, bond.centroid, bond.normal}});
    }
  }
  return bonds;
}

/// Linear in the number of cells and in the pieces of contacts of changed parts.
std::vector<ChangedBond> changed_contact_bonds(const ContactBonds& with, const HitOutcome& hit,
                                               const Execution& execution) {
  if (hit.changed.empty() || !parts_hold_together(with.solid)) return {};
  Pacer pacer(execution);
  std::vector<PlaceInAnswer> places;
  std::vector<const Fragment*> fragments;
  std::vector<char> wanted;
  auto next = hit.changed.begin();
  for (const SiteId s : ids<SiteId>(hit.next.cells.size())) {
    pacer.step(8);
    const std::vector<KeptFragment>& here = hit.next.cells[s]->fragments;
    for (std::uint32_t k = 0; k < here.size(); ++k) {
      places.push_back({s, k});
      fragments.push_back(&here[k].fragment);
      const bool changed = next != hit.changed.end() && *next == places.back();
      wanted.push_back(changed ? 1 : 0);
      if (changed) ++next;
    }
  }
  std::vector<ChangedBond> bonds;
  for (const Bond& bond : find_contact_bonds(with, fragments, wanted, execution))
    bonds.push_back({places[bond.a], places[bond.b], bond});
  return bonds;
}

/// Whether fragments carry sheets.
bool carries_sheets(const Solid& solid) { return solid.sheets && !solid.sheets->whole; }

/// Returns the sites if bonds across parts or sheets need them, otherwise nothing.
std::vector<Vec3d> points_of(const Solid& solid, const LocalBase& base, const Execution& execution) {
  if (!parts_hold_together(solid) && !carries_sheets(solid)) return {};
  std::vector<Vec3d> points;
  points.reserve(base.tetrahedra.site_count());
  Pacer pacer(execution);
  for (const SiteId s : ids<SiteId>(base.tetrahedra.site_count())) {
    pacer.step();
    points.push_back(base.tetrahedra.site(s));
  }
  return points;
}

/// How the whole answer rests, with the filters of the new and changed fragments. Linear in the cells, and in what find_overlaps() is,
/// unless no two fragments can overlap.
Rest rest_of_changed(const Solid& solid, const HitOutcome& hit, const CellMap& map,
                     const FractureParameters& parameters, const Execution& execution) {
  Pacer pacer(execution);
  Bodies bodies;
  std::vector<std::uint32_t> index;  // of the new and changed fragments
  auto next = hit.changed.begin();
  for (const SiteId s : ids<SiteId>(hit.next.cells.size())) {
    pacer.step(8);
    const std::vector<KeptFragment>& here = hit.next.cells[s]->fragments;
    for (std::uint32_t k = 0; k < here.size(); ++k) {
      if (next != hit.changed.end() && *next == PlaceInAnswer{s, k}) {
        index.push_back(static_cast<std::uint32_t>(bodies.size()));
        ++next;
      }
      bodies.fragments.push_back(&here[k].fragment);
      bodies.hulls.push_back(&here[k].hulls);
    }
  }
  const FragmentFigures& figures = hit.next.figures;
  Rest rest = find_rest(bodies, cells_of_bodies(parameters, map, figures.pieces - figures.cells),
                        rest_tolerance(solid), parameters.filters, execution);
  keep_rest_of(rest, index, hit.delta);
  return rest;
}

/// Returns the new or changed fragments with their bonds, and adds the ids of these bonds' other ends to
/// `delta`.
CutCells changed_cells_of(const Solid& solid, const HitOutcome& hit, const CellSites& cells,
                          const FractureParameters& parameters, Delta& delta, const Execution& execution) {
  CutCells cut;
  FragmentSet& set = cut.set;
  set.source = solid.source;
  state_lattice(solid, set);
  Pacer pacer(execution);
  for (const PlaceInAnswer& place : hit.changed) {
    pacer.step(64);
    set.fragments.push_back(kept_at(hit, place).fragment);
    cut.hulls.of_fragment.push_back(kept_at(hit, place).hulls);
  }
  const std::vector<ChangedBond> caps = changed_cap_bonds(hit, pacer),
                                 contacts = changed_contact_bonds(
                                     {solid, cells, set.lattice_step, parameters.contact_strength}, hit,
                                     execution);
  std::vector<PlaceInAnswer> neighbors;
  for (const std::vector<ChangedBond>* bonds : {&caps, &contacts})
    for (const ChangedBond& bond : *bonds)
      for (const PlaceInAnswer& place : {bond.a, bond.b})
        if (number_in(hit.changed, place) == kNoIndex) neighbors.push_back(place);
  sort_with_polls(execution, neighbors.begin(), neighbors.end());
  neighbors.erase(std::unique(neighbors.begin(), neighbors.end()), neighbors.end());
  for (const PlaceInAnswer& place : neighbors) delta.neighbors.push_back(kept_at(hit, place).fragment.id);
  const auto number = [&](const PlaceInAnswer& place) {
    const std::uint32_t here = number_in(hit.changed, place);
    return here != kNoIndex ? here
                            : static_cast<std::uint32_t>(hit.changed.size()) + number_in(neighbors, place);
  };
  const auto numbered = [&](const std::vector<ChangedBond>& changed) {
    std::vector<Bond> bonds;
    for (const ChangedBond& bond : changed) {
      pacer.step(8);
      bonds.push_back(bond.bond);
      bonds.back().a = number(bond.a);
      bonds.back().b = number(bond.b);
    }
    point_upwards(bonds, execution);
    return bonds;
  };
  set.bonds = with_contact_bonds(numbered(caps), numbered(contacts), execution);

  const FragmentFigures& figures = hit.next.figures;
  set.certificate = certificate_of(solid, figures);
  set.size = hit.next.size;
  if (hit.next.rough) cut.rough = hit.next.rough->report;
  cut.whole = CutCells::Whole{figures.sorted_volumes, figures.triangles, figures.hulls};
  if (parameters.hulls == Hulls::kConvex)
    cut.whole->rest = rest_of_changed(solid, hit, cells.map, parameters, execution);
  return cut;
}

/// Cuts all sheets again, because a piece may go to a fragment that the hit does not change. Adds the fragments of
/// which only the sheets differ to the delta. Returns false if the sites are not those of the whole fracture.
bool carry_sheets_after(const Solid& solid, const std::vector<Vec3d>& points, HitOutcome& hit,
                        FragmentSet& set, const Execution& execution) {
  const Box& box = hit.next.image ? hit.next.image->box : solid.box;
  const Expected<Tetrahedralization> t = tetrahedralize(points, box, execution);
  if (!t) throw Interrupted(t.error());
  if (t->site_count() != points.size()) return false;
  carry_sheets(solid, VoronoiDiagram(*t, box, hit.next.map, execution), box, set, execution);
  const auto sorted = [&](std::vector<std::uint64_t> ids) {
    sort_with_polls(execution, ids.begin(), ids.end());
    return ids;
  };
  const std::vector<std::uint64_t> added = sorted(hit.delta.added), changed = sorted(hit.delta.changed);
  const auto is_in = [](const std::vector<std::uint64_t>& ids, std::uint64_t id) {
    return std::binary_search(ids.begin(), ids.end(), id);
  };
  auto sheets = std::make_shared<KeptSheets>();
  hit.delta.changed.clear();
  Pacer pacer(execution);
  for (const Fragment& f : set.fragments) {
    pacer.step(16);
    if (f.sheet) sheets->emplace(f.id, f.sheet);
    if (is_in(added, f.id)) continue;
    const auto before = hit.next.sheets->find(f.id);
    const Fragment* const was = before == hit.next.sheets->end() ? nullptr : before->second.get();
    if (is_in(changed, f.id) || !same_sheet(was, f.sheet.get())) hit.delta.changed.push_back(f.id);
  }
  hit.next.sheets = std::move(sheets);
  return true;
}

/// Returns nothing if the hits change more than the cells around them, or if the combination of stored and
/// new fragments fails its check. Errors of plan_sites(). Throws Interrupted.
Expected<std::optional<KeptAnswer>> answer_locally(const Solid& solid, const LocalBase& base,
                                                   const FractureParameters& parameters,
                                                   const NewHits& new_hits, const Execution& execution,
                                                   StageTimings& timings) {
  SitePlan plan{{}, {}, base.map, base.notes.remarks};
  auto added = stage(timings, execution, Stage::kTetrahedralize, [&] {
    return append_hits(solid, parameters, parameters.hits, parameters.hits.size() - new_hits.count,
                       base.notes.figures.given, plan, execution);
  });
  if (!added) return tl::unexpected(added.error());
  return stage(timings, execution, Stage::kClip, [&]() -> Expected<std::optional<KeptAnswer>> {
    std::optional<HitOutcome> hit =
        hit_cells(solid, base, plan.points, plan.groups_of_hits, parameters, execution);
    if (!hit) return std::nullopt;
    hit->next.notes.remarks = std::move(plan.remarks);
    const std::vector<Vec3d> points = points_of(solid, hit->next, execution);
    const bool sheets = carries_sheets(solid), part = new_hits.only_changed && !sheets;
    CutCells cut =
        part ? changed_cells_of(solid, *hit, {points, hit->next.map}, parameters, hit->delta, execution)
             : all_cells_of(solid, hit->next, execution);
    if (sheets && !carry_sheets_after(solid, points, *hit, cut.set, execution)) return std::nullopt;
    Expected<FracturedSolid> completed =
        complete(solid, hit->next.notes, parameters, std::move(cut), {points, hit->next.map}, execution);
    if (!completed) return std::nullopt;  // the whole is then made from scratch and decides
    if (completed->rest && completed->rest->trimmed_for_filters)
      return std::nullopt;  // hulls of bodies far away change, too
    completed->delta = std::move(hit->delta);
    if (new_hits.only_changed && !part) keep_changed(*completed, execution);
    return KeptAnswer{std::move(*completed), {std::move(hit->next)}, true};
  });
}

}  // namespace

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
    LocalBaseMaker maker;
    std::optional<RoughTrace> trace;
    bool local = may_be_local(parameters);
    Expected<CutCells> cut = cut_cells(
        solid, diagram, parameters, execution,
        [&](const RestrictedDiagram& restricted) {
          if (local) maker.see(restricted, execution);
        },
        local ? &trace : nullptr);
    if (!cut) return tl::unexpected(cut.error());
    const Certificate& c = cut->set.certificate;
    local = local && c.united == cut->set.size.united && (cut->late.empty() || !parameters.hits.empty()) &&
            c.dropped == 0 && c.crossing_caps == 0 && (trace || !(parameters.roughness.amplitude > 0));
    if (local) maker.see(*cut, parts_hold_together(solid));
    const RoughReport rough = cut->rough;
    KeptAnswer out;
    Expected<FracturedSolid> completed =
        complete(solid, notes_of(diagram), parameters, std::move(*cut),
                 {diagram.tetrahedralization.points, diagram.map}, execution);
    if (!completed) return tl::unexpected(std::move(completed.error()));
    out.fractured = std::move(*completed);
    // Kept bodies must not depend on bodies far away.
    local = local && !(out.fractured.rest && out.fractured.rest->trimmed_for_filters);
    if (local) out.base.local = maker.make(out.fractured, diagram, execution);
    if (out.base.local && trace)
      out.base.local->rough =
          keep_cuts(std::move(*trace), rough, diagram.tetrahedralization.site_count(), execution);
    if (!out.base.local)
      for (std::uint32_t k = 0; k < out.fractured.set.fragments.size(); ++k)
        out.base.fragments.push_back(kept_fragment(out.fractured, k, execution));
    return out;
  });
}

FractureParameters before_hits(FractureParameters parameters, std::uint32_t new_hits) {
  parameters.hits.resize(parameters.hits.size() - new_hits);
  return parameters;
}

Expected<KeptAnswer> fracture_delta(const Solid& solid, const FracturedBase& base,
                                    const FractureParameters& parameters, const NewHits& new_hits,
                                    const Execution& execution, StageTimings& timings) {
  if (base.local && parameters.rest == LocalRest::kFractured) {
    auto answer = answer_locally(solid, *base.local, parameters, new_hits, execution, timings);
    if (!answer) return tl::unexpected(answer.error());
    if (*answer) return std::move(**answer);
  }
  Expected<KeptAnswer> whole = fracture_and_keep(solid, parameters, execution, timings);
  if (!whole) return whole;
  return stage(timings, execution, Stage::kClip, [&]() -> Expected<KeptAnswer> {
    FracturedSolid& fractured = whole->fractured;
    fractured.delta = difference(base, fractured, execution);
    if (new_hits.only_changed) keep_changed(fractured, execution);
    return std::move(*whole);
  });
}

}  // namespace fracture
