#include "common/pipeline/delta.hpp"
#include "common/base/pacer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <utility>

#include "common/fragment/assemble.hpp"
#include "common/fragment/file_volume.hpp"
#include "common/fragment/make_fragments.hpp"
#include "common/pipeline/difference.hpp"
#include "common/pipeline/fracture_steps.hpp"
#include "common/solid/image.hpp"

namespace fracture {
namespace {

/// The sites of the new hits in the tetrahedralization of the base, and what they change.
struct Insertion {
  Diagram diagram;
  SiteId first_new{0};         ///< sites from here on are new
  std::vector<char> changed;   ///< per site: new, or of a cell that is not what it was
  std::vector<char> wanted;    ///< the same, and cells of several fragments beside them
  std::vector<TetId> tet_now;  ///< per tetrahedron of the base: its number, or kNoTet
};

/// Sites that stand with one that is `touched` in a tetrahedron.
template <class Touched, class Visit>
void visit_neighbors(const Tetrahedralization& t, const Touched& touched, const Visit& visit) {
  for (const Tetrahedron& tet : t.tets) {
    if (std::none_of(tet.v.begin(), tet.v.end(), [&](SiteId s) { return !t.is_corner(s) && touched(s); }))
      continue;
    for (const SiteId s : tet.v)
      if (!t.is_corner(s)) visit(s);
  }
}

/// Both are canonical, so what stays keeps its order; and what has no new site stays.
std::vector<TetId> numbers_now(const Tetrahedralization& before, const Tetrahedralization& now,
                               SiteId first_new) {
  const auto same = [&](const Tetrahedron& a, const Tetrahedron& b) {
    for (int k = 0; k < 4; ++k) {
      const bool corner = before.is_corner(a.v[k]);
      if (corner != now.is_corner(b.v[k])) return false;
      if (a.v[k] - (corner ? before.site_count() : 0) != b.v[k] - (corner ? now.site_count() : 0))
        return false;
    }
    return true;
  };
  std::vector<TetId> result(before.tets.size(), kNoTet);
  TetId old{0};
  for (const TetId t : ids<TetId>(now.tets.size())) {
    const auto& v = now.tets[t].v;
    if (std::any_of(v.begin(), v.end(), [&](SiteId s) { return s >= first_new && !now.is_corner(s); }))
      continue;
    while (old < before.tets.size() && !same(before.tets[old], now.tets[t])) ++old;
    if (old == before.tets.size())
      throw InternalError("a tetrahedron without a new site was not there before");
    result[old++] = t;
  }
  return result;
}

/// Nothing where the hits change more than the cells around them. Errors of plan_sites().
Expected<std::optional<Insertion>> insert_hits(const Solid& solid, const Box& box, const FracturedBase& base,
                                               const FractureParameters& parameters, std::uint32_t new_hits,
                                               const Execution& execution) {
  SitePlan plan{{}, {}, base.diagram.map, base.diagram.notes};
  const std::size_t first = parameters.hits.size() - new_hits;
  if (auto added = append_hits(solid, parameters, parameters.hits, first, plan, execution); !added)
    return tl::unexpected(added.error());
  std::optional<Tetrahedralization> now =
      insert_sites(base.diagram.tetrahedralization, plan.points, box, execution);
  if (!now) return std::nullopt;

  Insertion in;
  in.first_new = SiteId{base.diagram.tetrahedralization.site_count()};
  in.tet_now = numbers_now(base.diagram.tetrahedralization, *now, in.first_new);
  std::vector<char>& changed = in.changed;
  changed.assign(now->site_count(), 0);
  visit_neighbors(
      *now, [&](SiteId s) { return s >= in.first_new; }, [&](SiteId s) { changed[s] = 1; });
  // Which of several fragments of a cell a cap leads to is only known when they are all there.
  in.wanted = changed;
  visit_neighbors(
      *now, [&](SiteId s) { return changed[s] != 0; },
      [&](SiteId s) {
        if (s < in.first_new && base.first_of[s + 1] - base.first_of[s] > 1) in.wanted[s] = 1;
      });
  in.diagram.sites = base.diagram.sites;
  in.diagram.sites.insert(in.diagram.sites.end(), plan.points.begin(), plan.points.end());
  in.diagram.map = base.diagram.map;
  in.diagram.notes = std::move(plan.notes);
  in.diagram.tetrahedralization = std::move(*now);
  return in;
}

/// What was made of the cells of interest, and what was there, as one answer.
class Splicer {
 public:
  Splicer(const FracturedBase& base, const Insertion& in, const WantedFragments& made)
      : base_(base),
        made_(made),
        from_base_(made.first_of.back(), kNoIndex),
        now_(base.fragments.size(), kNoIndex),
        unchanged_(made.first_of.back(), 0) {
    for (const SiteId s : ids<SiteId>(in.first_new)) {
      if (in.changed[s]) continue;
      for (std::uint32_t f = base.first_of[s]; f < base.first_of[s + 1]; ++f) {
        const std::uint32_t k = made.first_of[s] + f - base.first_of[s];
        now_[f] = k;
        unchanged_[k] = 1;
        if (!in.wanted[s]) from_base_[k] = f;
      }
    }
  }

  /// Per fragment: its number in the base, when it is not of a cell of interest.
  const std::vector<std::uint32_t>& from_base() const { return from_base_; }

  /// With `only_changed` the others have no shape, only figures.
  void fill(std::vector<Fragment> made, bool only_changed, CutCells& out) const {
    std::vector<Fragment>& all = out.set.fragments;
    all.resize(from_base_.size());
    out.hulls.of_fragment.resize(all.size());
    std::size_t next = 0;
    for (std::uint32_t k = 0; k < all.size(); ++k) {
      if (from_base_[k] == kNoIndex) {
        all[k] = std::move(made[next++]);
        continue;
      }
      const FracturedBase::Known& base = *base_.fragments[from_base_[k]];
      const Fragment& known = base.fragment;
      if (!only_changed) {
        all[k] = known;
        out.hulls.of_fragment[k] = base.hulls;
        continue;
      }
      all[k].id = known.id;
      all[k].sites = known.sites;
      all[k].part = known.part;
      all[k].mass = known.mass;
      all[k].exterior_area = known.exterior_area;
      all[k].surface_area = known.surface_area;
      all[k].cap_sum = known.cap_sum;
      out.further_triangles += known.indices.size() / 3;
      out.further_hulls.hulls += static_cast<std::uint32_t>(base.hulls.hulls.size());
      out.further_hulls.flat += base.hulls.flat;
      out.further_hulls.simplified += base.hulls.simplified;
    }
  }

  std::vector<double> volumes_file() const {
    std::vector<double> all(from_base_.size());
    std::size_t next = 0;
    for (std::uint32_t k = 0; k < all.size(); ++k)
      all[k] = from_base_[k] == kNoIndex ? made_.volumes_file[next++]
                                         : base_.fragments[from_base_[k]]->volume_file;
    return all;
  }

  /// Those of changed cells as they were made, the others as they were: a cell beside a changed one may be of
  /// interest and touch cells of which only the number of fragments is known here.
  std::vector<Bond> bonds() const {
    std::vector<Bond> stay, made, all;
    for (Bond b : base_.bonds) {
      b.a = now_[b.a];
      b.b = now_[b.b];
      if (b.a != kNoIndex && b.b != kNoIndex) stay.push_back(b);
    }
    std::copy_if(made_.bonds.begin(), made_.bonds.end(), std::back_inserter(made),
                 [&](const Bond& b) { return !unchanged_[b.a] || !unchanged_[b.b]; });
    std::merge(stay.begin(), stay.end(), made.begin(), made.end(), std::back_inserter(all),
               [](const Bond& x, const Bond& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
    return all;
  }

 private:
  const FracturedBase& base_;
  const WantedFragments& made_;
  std::vector<std::uint32_t> from_base_;
  std::vector<std::uint32_t> now_;  // per fragment of the base in a cell that did not change: its number
  std::vector<char> unchanged_;     // per fragment: such a one
};

/// As make_fragments() sums it. Nothing was united or dropped, no loops crossed outside of the cells of
/// interest.
Certificate certificate_of(const Solid& solid, const std::vector<Fragment>& fragments,
                           const std::vector<double>& volumes_file, const WantedFragments& made) {
  Certificate c;
  c.crossing_caps = made.crossing_caps;
  for (std::size_t k = 0; k < fragments.size(); ++k) {
    c.volume_out += fragments[k].mass.volume;
    c.volume_file += volumes_file[k];
    c.cells += k == 0 || fragments[k].sites[0] != fragments[k - 1].sites[0];
  }
  c.fragments = static_cast<std::uint32_t>(fragments.size());
  c.islands = c.fragments - c.cells;
  sum_up(solid, fragments, c);
  return c;
}

std::vector<std::uint32_t> ranges_by_site(const std::vector<Fragment>& fragments, std::uint32_t sites) {
  std::vector<std::uint32_t> first_of(sites + 1, 0);
  for (const Fragment& f : fragments) ++first_of[f.sites[0] + 1];
  for (std::uint32_t s = 0; s < sites; ++s) first_of[s + 1] += first_of[s];
  return first_of;
}

/// Two fragments with the same id: a hash collision, which the whole answer resolves.
bool ids_collide(const std::vector<Fragment>& fragments) {
  std::vector<std::uint64_t> ids;
  for (const Fragment& f : fragments) ids.push_back(f.id);
  std::sort(ids.begin(), ids.end());
  return std::adjacent_find(ids.begin(), ids.end()) != ids.end();
}

std::shared_ptr<const FracturedBase::Known> known(const FracturedSolid& answer, std::uint32_t fragment,
                                                  double volume_file) {
  const std::vector<FragmentHulls>& hulls = answer.hulls.of_fragment;
  return std::make_shared<const FracturedBase::Known>(FracturedBase::Known{
      answer.set.fragments[fragment], hulls.empty() ? FragmentHulls() : hulls[fragment], volume_file});
}

/// Nothing where a piece would have to be united or dropped, or what was kept does not prove itself with what
/// is new.
std::optional<KeptAnswer> splice(const SeenSolid& whole, const FracturedBase& base, Insertion in,
                                 const FractureParameters& parameters, bool only_changed,
                                 const Execution& execution) {
  const Tetrahedralization& t = in.diagram.tetrahedralization;
  const Solid &solid = whole.original(), &seen = whole.seen();
  const VoronoiDiagram voronoi(t, seen.box, in.diagram.map, execution);
  FracturedBase next;
  next.surface = base.surface;
  RestrictedDiagram r{solid, seen, voronoi,
                      cut_surface_again(seen, voronoi, next.surface, in.wanted, execution)};
  r.winding = wind_voronoi_edges_again(seen, voronoi, r.cuts, {in.wanted, in.tet_now, base.inner_vertices},
                                       execution);
  r.place_and_cap(execution, &in.wanted);

  Ownership ownership = Ownership::from_groups(t.site_count(), {}, execution);
  ownership.wanted.assign(in.wanted.begin(), in.wanted.end());
  std::vector<std::uint32_t> others(t.site_count(), 0);
  for (const SiteId s : ids<SiteId>(in.first_new))
    if (!in.wanted[s]) others[s] = base.first_of[s + 1] - base.first_of[s];
  std::optional<WantedFragments> made =
      make_wanted_fragments(r, ownership, others, parameters.pivot, execution);
  if (!made) return std::nullopt;

  const Splicer splicer(base, in, *made);
  CutCells cut;
  cut.set.source = solid.source;
  cut.set.bonds = splicer.bonds();
  splicer.fill(std::move(made->fragments), only_changed, cut);
  if (ids_collide(cut.set.fragments)) return std::nullopt;
  const std::vector<double> volumes_file = splicer.volumes_file();
  cut.set.certificate = certificate_of(solid, cut.set.fragments, volumes_file, *made);
  state_lattice(r, cut.set);
  next.bonds = cut.set.bonds;

  Expected<FracturedSolid> completed = complete(solid, in.diagram, parameters, std::move(cut), execution);
  if (!completed) return std::nullopt;  // the whole, made from nothing, has the last word
  KeptAnswer out;
  out.fractured = std::move(*completed);
  FragmentSet& set = out.fractured.set;
  const std::vector<std::uint32_t>& from_base = splicer.from_base();
  out.fractured.delta = difference(
      base, set.fragments, [&](std::uint32_t k) { return from_base[k] != kNoIndex; }, execution);

  for (std::uint32_t k = 0; k < from_base.size(); ++k)
    next.fragments.push_back(from_base[k] != kNoIndex ? base.fragments[from_base[k]]
                                                      : known(out.fractured, k, volumes_file[k]));
  next.first_of = std::move(made->first_of);
  for (InnerVertex v : base.inner_vertices) {
    v.tet = in.tet_now[v.tet];
    if (v.tet == kNoTet) continue;
    const auto& sites = t.tets[v.tet].v;
    if (std::none_of(sites.begin(), sites.end(), [&](SiteId s) { return !t.is_corner(s) && in.wanted[s]; }))
      next.inner_vertices.push_back(v);
  }
  next.inner_vertices.insert(next.inner_vertices.end(), r.winding.inner_vertices.begin(),
                             r.winding.inner_vertices.end());
  next.local = set.certificate.crossing_caps == 0;
  next.diagram = std::move(in.diagram);
  if (only_changed) keep_changed(out.fractured, execution);
  out.base = std::move(next);
  return out;
}

}  // namespace

Expected<KeptAnswer> fracture_and_keep(const Solid& solid, const FractureParameters& parameters,
                                       const Execution& execution, StageTimings& timings) {
  Expected<Diagram> diagram = make_diagram(solid, parameters, execution, timings);
  if (!diagram) return tl::unexpected(diagram.error());
  return fracture_and_keep(solid, std::move(*diagram), parameters, execution, timings);
}

Expected<KeptAnswer> fracture_and_keep(const Solid& solid, Diagram diagram,
                                       const FractureParameters& parameters, const Execution& execution,
                                       StageTimings& timings) {
  return stage(timings, execution, Stage::kClip, [&]() -> Expected<KeptAnswer> {
    FracturedBase base;
    Expected<CutCells> cut =
        cut_cells(solid, diagram, parameters, execution, [&](const RestrictedDiagram& restricted) {
          base.surface = labels_of(restricted.cuts);
          base.inner_vertices = restricted.winding.inner_vertices;
          base.local = true;
        });
    if (!cut) return tl::unexpected(cut.error());
    const Certificate& c = cut->set.certificate;
    base.local = base.local && !cut->grouped && !parameters.keep && !parameters.size.any() &&
                 parameters.max_volume == 0 && !(parameters.roughness.amplitude > 0) && c.united == 0 &&
                 c.dropped == 0 && c.crossing_caps == 0;
    base.bonds = cut->set.bonds;
    KeptAnswer out;
    Expected<FracturedSolid> completed = complete(solid, diagram, parameters, std::move(*cut), execution);
    if (!completed) return tl::unexpected(std::move(completed.error()));
    out.fractured = std::move(*completed);
    const std::vector<Fragment>& fragments = out.fractured.set.fragments;
    for (std::uint32_t k = 0; k < fragments.size(); ++k)
      base.fragments.push_back(known(out.fractured, k, file_volume(fragments[k], execution).volume));
    if (base.local) base.first_of = ranges_by_site(fragments, diagram.tetrahedralization.site_count());
    base.diagram = std::move(diagram);
    out.base = std::move(base);
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
  const bool local = base.local && parameters.rest == LocalRest::kFractured;
  std::optional<KeptAnswer> answer;
  if (local) {
    const SeenSolid seen(solid, base.diagram.map, execution);
    auto in = stage(timings, execution, Stage::kTetrahedralize, [&]() -> Expected<std::optional<Insertion>> {
      return insert_hits(solid, seen.seen().box, base, parameters, new_hits.count, execution);
    });
    if (!in) return tl::unexpected(in.error());
    if (*in) {
      auto spliced = stage(timings, execution, Stage::kClip, [&]() -> Expected<std::optional<KeptAnswer>> {
        return splice(seen, base, std::move(**in), parameters, new_hits.only_changed, execution);
      });
      if (!spliced) return tl::unexpected(spliced.error());
      answer = std::move(*spliced);
    }
  }
  if (answer) return std::move(*answer);
  Expected<KeptAnswer> whole = fracture_and_keep(solid, parameters, execution, timings);
  if (!whole) return whole;
  return stage(timings, execution, Stage::kClip, [&]() -> Expected<KeptAnswer> {
    FracturedSolid& fractured = whole->fractured;
    fractured.delta = difference(
        base, fractured.set.fragments, [](std::uint32_t) { return false; }, execution);
    if (new_hits.only_changed) keep_changed(fractured, execution);
    return std::move(*whole);
  });
}

}  // namespace fracture
