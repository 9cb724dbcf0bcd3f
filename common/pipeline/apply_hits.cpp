#include <algorithm>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/random.hpp"
#include "common/base/words.hpp"
#include "common/fragment/make_fragments.hpp"
#include "common/physics/hull_trim.hpp"
#include "common/pipeline/broken_solid.hpp"
#include "common/pipeline/cell_groups.hpp"
#include "common/pipeline/cut_again.hpp"
#include "common/pipeline/earlier_bonds.hpp"
#include "common/pipeline/kept_space.hpp"
#include "common/pipeline/part_sets.hpp"

namespace fracture {
namespace {

void sort_bonds(std::vector<Bond>& bonds, const Execution& execution) {
  sort_with_polls(execution, bonds.begin(), bonds.end(),
                  [](const Bond& x, const Bond& y) { return std::tie(x.a, x.b) < std::tie(y.a, y.b); });
}

/// Sorts fragments by their first sites, parts and ids, so that a client can find the order from an earlier answer and the changes.
void sort_fragments(BrokenSolid& broken, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<SharedFragment>& all = broken.fragments;
  const auto is_before = [](const SharedFragment& a, const SharedFragment& b) {
    const auto key = [](const Fragment& f) { return std::tuple(f.sites.front(), f.part, f.id); };
    return key(a->fragment) < key(b->fragment);
  };
  if (std::is_sorted(all.begin(), all.end(), is_before)) return;
  std::vector<std::uint32_t> order(all.size()), place(all.size());
  std::iota(order.begin(), order.end(), 0u);
  sort_with_polls(execution, order.begin(), order.end(),
                  [&](std::uint32_t a, std::uint32_t b) { return is_before(all[a], all[b]); });
  std::vector<SharedFragment> sorted;
  sorted.reserve(all.size());
  for (std::uint32_t k = 0; k < order.size(); ++k) {
    pacer.step(2);
    place[order[k]] = k;
    sorted.push_back(std::move(all[order[k]]));
  }
  all = std::move(sorted);
  for (Bond& bond : broken.cut.set.bonds) {
    pacer.step();
    bond.a = place[bond.a];
    bond.b = place[bond.b];
    if (bond.a < bond.b) continue;
    std::swap(bond.a, bond.b);
    for (int axis = 0; axis < 3; ++axis) bond.normal[axis] = bond.normal[axis] == 0 ? 0 : -bond.normal[axis];
  }
  sort_bonds(broken.cut.set.bonds, execution);
}

/// A hit on the parts of one set. The cells and the parameters are those of the set.
class Hit {
 public:
  Hit(const Solid& solid, const PartSet& set, const HitCells& cells, BrokenSolid& broken,
      const Execution& execution)
      : solid_(solid),
        parameters_(set.parameters),
        parts_(set.parts),
        cells_(cells),
        broken_(broken),
        execution_(execution),
        pacer_(execution) {}

  /// Returns whether it cuts anything.
  Expected<bool> run() {
    if (auto cut = cut_fragments(); !cut) return tl::unexpected(std::move(cut.error()));
    if (touched_.empty()) return false;
    allow_pieces();
    trim_hulls();
    number_fragments();
    name_pieces();
    divide_bonds();
    count();
    replace_fragments();
    return true;
  }

 private:
  std::uint32_t size_before() const { return static_cast<std::uint32_t>(broken_.fragments.size()); }
  const KeptFragment& before(std::uint32_t k) const { return *broken_.fragments[k]; }
  const PiecesOfFragment& made(std::size_t t) const { return *made_[t]; }
  bool is_in_set(std::uint32_t part) const {
    return parts_.empty() || std::binary_search(parts_.begin(), parts_.end(), part);
  }

  bool is_hit(const Fragment& f) const {
    return is_hit_.empty() || is_hit_[f.part] ||
           std::any_of(f.part_cells.begin(), f.part_cells.end(),
                       [&](const PartCell& cell) { return is_hit_[cell.part] != 0; });
  }

  Expected<void> cut_fragments() {
    if (solid_.parts.size() > 1)
      is_hit_ = parts_in_ball(solid_, parameters_.hits[broken_.hits], cells_.reach, execution_);
    std::vector<std::uint32_t> near;
    for (std::uint32_t k = 0; k < size_before(); ++k) {
      pacer_.step();
      if (before(k).box.intersects(cells_.reach) && is_in_set(before(k).fragment.part) &&
          is_hit(before(k).fragment))
        near.push_back(k);
    }
    const VoronoiDiagram diagram(cells_.dual, cells_.image, cells_.map, execution_);
    const SizeLimits limits = limits_of_hits(parameters_, solid_.report.volume);
    const HitOnFragments hit{solid_, cells_, diagram, parameters_, limits};
    const Allowance::Temporary temporary(execution_.allowance);  // only the pieces are kept (allow_pieces)
    std::vector<std::optional<Expected<std::optional<PiecesOfFragment>>>> results(near.size());
    if (near.size() == 1) {
      results[0] = cut_again(hit, before(near[0]), execution_);
    } else {
      Execution single = execution_;
      single.threads = 1;
      single.progress = {};
      single.within = nullptr;
      parallel_for(execution_, near.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) results[k] = cut_again(hit, before(near[k]), single);
      });
    }
    for (std::size_t k = 0; k < near.size(); ++k) {
      Expected<std::optional<PiecesOfFragment>>& result = *results[k];
      if (!result) return tl::unexpected(std::move(result.error()));
      if (!*result) continue;
      touched_.push_back(near[k]);
      made_.push_back(std::move(*result));
    }
    return {};
  }

  /// Counts what the pieces add to the answer. Everything else that was made for them is gone.
  void allow_pieces() {
    std::uint64_t before_cuts = 0, now = 0;
    for (std::size_t t = 0; t < touched_.size(); ++t) {
      pacer_.step(1 + made(t).pieces.size());
      before_cuts += before(touched_[t]).fragment.indices.size() / 3;
      for (const KeptFragment& piece : made(t).pieces) now += piece.fragment.indices.size() / 3;
    }
    if (now > before_cuts) execution_.made(Product::kFragmentTriangles, now - before_cuts);
  }

  /// Hulls of unchanged fragments were trimmed before.
  void trim_hulls() {
    if (!broken_.with_hulls) return;
    FragmentSet set;
    CollisionHulls hulls;
    const auto each_piece = [&](const auto& visit) {
      for (std::optional<PiecesOfFragment>& made : made_)
        for (KeptFragment& piece : made->pieces) visit(piece);
    };
    each_piece([&](KeptFragment& piece) {
      pacer_.step(8);
      set.fragments.push_back(std::move(piece.fragment));
      hulls.of_fragment.push_back(std::move(piece.hulls));
    });
    trim_at_contacts(set, solid_, hulls, execution_);
    std::size_t k = 0;
    each_piece([&](KeptFragment& piece) {
      piece.fragment = std::move(set.fragments[k]);
      piece.hulls = std::move(hulls.of_fragment[k++]);
    });
  }

  /// Finds the new number of each fragment: pieces take the place of the fragment that they come from.
  void number_fragments() {
    first_.reserve(size_before() + 1);
    std::uint32_t next = 0;
    std::size_t t = 0;
    for (std::uint32_t k = 0; k < size_before(); ++k) {
      pacer_.step();
      first_.push_back(next);
      const bool touched = t < touched_.size() && touched_[t] == k;
      next += touched ? static_cast<std::uint32_t>(made(t++).pieces.size()) : 1;
    }
    first_.push_back(next);
  }
  bool is_touched(std::uint32_t k) const { return std::binary_search(touched_.begin(), touched_.end(), k); }

  /// The largest piece of the rest keeps the id. Other ids follow from it and from the pieces' own sites.
  void name_pieces() {
    std::vector<std::pair<std::uint64_t, Fragment*>> fresh;
    for (std::size_t t = 0; t < touched_.size(); ++t) {
      PiecesOfFragment& made = *made_[t];
      const std::uint64_t id = before(touched_[t]).fragment.id;
      std::size_t largest = kNoIndex;
      for (std::size_t k = 0; k < made.pieces.size(); ++k)
        if (made.is_rest[k] && (largest == kNoIndex || made.pieces[k].fragment.mass.volume >
                                                           made.pieces[largest].fragment.mass.volume))
          largest = k;
      for (std::size_t k = 0; k < made.pieces.size(); ++k) {
        pacer_.step(8);
        Fragment& f = made.pieces[k].fragment;
        if (k == largest) {
          f.id = id;
          continue;
        }
        // Islands of one cell have the same name, and are numbered in their order.
        const auto island = static_cast<std::uint64_t>(std::count(
            made.names.begin(), made.names.begin() + static_cast<std::ptrdiff_t>(k), made.names[k]));
        f.id = mix64(mix64(mix64(id, broken_.hits + 1), made.names[k]), island) >> 11;
        fresh.emplace_back(f.id, &f);
      }
    }
    make_distinct(fresh);
  }
  /// Two ids are equal with a probability of about 2^-53 for each pair.
  void make_distinct(std::vector<std::pair<std::uint64_t, Fragment*>>& fresh) {
    const auto taken_before = [&](std::uint64_t id) {
      return std::any_of(broken_.fragments.begin(), broken_.fragments.end(),
                         [&](const SharedFragment& kept) { return kept->fragment.id == id; });
    };
    std::vector<std::uint64_t> ids;
    for (const auto& [id, f] : fresh) ids.push_back(id);
    std::sort(ids.begin(), ids.end());
    bool distinct = std::adjacent_find(ids.begin(), ids.end()) == ids.end();
    for (const SharedFragment& kept : broken_.fragments) {
      pacer_.step();
      distinct = distinct && !std::binary_search(ids.begin(), ids.end(), kept->fragment.id);
    }
    if (distinct) return;
    std::vector<std::uint64_t> used;
    for (const auto& [id, f] : fresh) {
      while (taken_before(f->id) || std::find(used.begin(), used.end(), f->id) != used.end())
        f->id = (f->id + 1) & ((1ull << 53) - 1);
      used.push_back(f->id);
    }
  }

  void divide_bonds() {
    std::vector<Bond> stay, divide;
    std::vector<std::uint32_t> beside;  // fragments that are not cut, but have a bond with one that is
    for (const Bond& bond : broken_.cut.set.bonds) {
      pacer_.step(2);
      const bool a = is_touched(bond.a), b = is_touched(bond.b);
      (a || b ? divide : stay).push_back(bond);
      if (a != b) beside.push_back(a ? bond.b : bond.a);
    }
    sort_with_polls(execution_, beside.begin(), beside.end());
    beside.erase(std::unique(beside.begin(), beside.end()), beside.end());
    std::vector<EarlierCuts> cuts;
    for (const std::uint32_t k : beside) cuts.push_back({&before(k), first_[k], k, before(k).fragment.caps});
    for (std::size_t t = 0; t < touched_.size(); ++t)
      for (std::size_t k = 0; k < made(t).pieces.size(); ++k)
        cuts.push_back({&made(t).pieces[k], first_[touched_[t]] + static_cast<std::uint32_t>(k), touched_[t],
                        made(t).earlier_caps[k]});
    std::vector<Bond> bonds = divided_bonds(divide, cuts, execution_);
    for (std::size_t t = 0; t < touched_.size(); ++t)
      for (Bond bond : made(t).bonds) {
        bond.a += first_[touched_[t]];
        bond.b += first_[touched_[t]];
        bonds.push_back(bond);
      }
    for (Bond bond : stay) {
      bond.a = first_[bond.a];
      bond.b = first_[bond.b];
      bonds.push_back(bond);
    }
    sort_bonds(bonds, execution_);
    broken_.cut.set.bonds = std::move(bonds);
  }

  void count() {
    Certificate& c = broken_.cut.set.certificate;
    for (std::size_t t = 0; t < touched_.size(); ++t) {
      const KeptFragment& gone = before(touched_[t]);
      const PiecesOfFragment& now = made(t);
      c.volume_out += now.certificate.pocket_volume - gone.fragment.mass.volume;
      c.pocket_volume += now.certificate.pocket_volume;
      c.pocket_area += now.certificate.pocket_area;
      c.crossing_caps += now.certificate.crossing_caps;
      c.united += now.certificate.united;
      c.dropped += now.certificate.dropped;
      // All pieces are further pieces of the fragment's cell.
      c.islands += now.certificate.cells + now.certificate.islands - 1;
      c.volume_file -= gone.volume_file;
      c.sheet_area_out += now.certificate.sheet_area_out - now.certificate.sheet_area_in;
      broken_.surface_area -= gone.fragment.surface_area;
      for (const KeptFragment& piece : now.pieces) {
        c.volume_out += piece.fragment.mass.volume;
        c.volume_file += piece.volume_file;
        broken_.surface_area += piece.fragment.surface_area;
      }
      CutCells& cut = broken_.cut;
      if (parameters_.rest == LocalRest::kWhole && cut.kept_share > 0) {
        double kept = 0;
        for (const KeptFragment& piece : now.pieces)
          if (piece.fragment.id == gone.fragment.id) kept = piece.fragment.mass.volume;
        cut.kept_share -= (gone.fragment.mass.volume - kept) / c.volume_in;
      }
      cut.set.size.united += now.size.united;
      cut.set.size.inside_out += now.size.inside_out;
      cut.set.size.alone += now.size.alone;
      cut.rough.triangles += now.rough.triangles;
      cut.rough.calmed += now.rough.calmed;
      cut.rough.crossing += now.rough.crossing;
      cut.rough.length = std::max(cut.rough.length, now.rough.length);
      const bool is_flat =
          now.all_flat || now.rough.given_up;  // only these cuts, not those of the whole answer
      cut.restrained_cells += is_flat ? static_cast<std::uint32_t>(now.pieces.size()) : now.restrained_cells;
    }
  }

  void replace_fragments() {
    std::vector<SharedFragment> all;
    all.reserve(first_.back());
    std::size_t t = 0;
    for (std::uint32_t k = 0; k < size_before(); ++k) {
      pacer_.step();
      if (t == touched_.size() || touched_[t] != k) {
        all.push_back(std::move(broken_.fragments[k]));
        continue;
      }
      for (KeptFragment& piece : made_[t]->pieces)
        all.push_back(std::make_shared<const KeptFragment>(std::move(piece)));
      ++t;
    }
    broken_.fragments = std::move(all);
    broken_.cut.grouped = broken_.cut.touch_across = true;
    Certificate& c = broken_.cut.set.certificate;
    c.fragments = static_cast<std::uint32_t>(broken_.fragments.size());
    ProofSums sums{.surface_area = broken_.surface_area + c.pocket_area};
    for (const SharedFragment& kept : broken_.fragments) {
      pacer_.step();
      sums.open_edges += kept->fragment.open_edges;
      sums.caps += kept->fragment.cap_sum;
    }
    sum_up(solid_, sums, c);
  }

  const Solid& solid_;
  const FractureParameters& parameters_;
  const std::vector<std::uint32_t>& parts_;  // of the set, ascending; empty: all
  const HitCells& cells_;
  BrokenSolid& broken_;
  const Execution& execution_;
  Pacer pacer_;
  std::vector<char> is_hit_;                           // per part; empty: the only part is hit
  std::vector<std::uint32_t> touched_;                 // numbers of the fragments that are cut, ascending
  std::vector<std::optional<PiecesOfFragment>> made_;  // for each of them
  std::vector<std::uint32_t> first_;  // per fragment before: its number or that of its first piece
};

struct Effect {
  bool has_cells = false, cuts = false;
};

/// Cuts the fragments of one set. Adds remarks.
Expected<Effect> hit_set(const Solid& solid, const PartSet& set, Remarks& remarks, BrokenSolid& broken,
                         const Execution& execution) {
  const FractureParameters& parameters = set.parameters;
  Expected<HitCells> cells = cells_of_hit(set.solid_in(solid), parameters, parameters.hits, broken.hits,
                                          parameters.keep, remarks, execution);
  if (!cells) return tl::unexpected(std::move(cells.error()));
  SiteFigures& figures = broken.notes.figures;
  figures.given += cells->sites + cells->duplicates;
  figures.used += cells->sites;
  figures.duplicates_merged += cells->duplicates;
  if (cells->empty()) return Effect{};
  spare_region(solid, parameters, *cells, execution);
  const Expected<bool> cuts = Hit(solid, set, *cells, broken, execution).run();
  if (!cuts) return tl::unexpected(cuts.error());
  return Effect{true, *cuts};
}

}  // namespace

Expected<void> apply_hits(const Solid& solid, const FractureParameters& parameters, BrokenSolid& broken,
                          const Execution& execution) {
  // make_diagram() checks the hits that it knows. A stored answer does not know the new ones.
  if (auto few = check_sites_of_hits(parameters, parameters.hits, broken.of_pattern); !few) return few;
  for (; broken.hits < parameters.hits.size(); ++broken.hits) {
    Remarks remarks;
    Effect all;
    for (const PartSet& set : sets_near_hit(solid, parameters, parameters.hits[broken.hits], execution)) {
      const Expected<Effect> done = hit_set(solid, set, remarks, broken, execution);
      if (!done) return tl::unexpected(done.error());
      all.has_cells = all.has_cells || done->has_cells;
      all.cuts = all.cuts || done->cuts;
    }
    sort_fragments(
        broken,
        execution);  // also if nothing was cut, because islands are in another order before the first hit
    if (all.has_cells)
      remarks.warnings.clear();  // they say that the hit has no room among the parts of some set
    if (all.has_cells && !all.cuts)
      remarks.warn(
          "Hit " + grouped(broken.hits + 1) +
          " cuts nothing, because each fragment in its reach lies in a single cell of the hit, or in the region to keep. "
          "Give a larger 'local_sites', or move 'local_point'.");
    broken.notes.remarks.add(remarks);
  }
  return {};
}

}  // namespace fracture
