#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/fragment/part_quotas.hpp"
#include "common/fragment/smallest_first.hpp"
#include "common/fragment/union_triangles.hpp"
#include "common/fragment/unite.hpp"

namespace fracture {
namespace {

using Unions = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// A group without neighbours that has less than this share of the solid's volume takes no fragment from its family.
/// Slivers of an answer that is fractured again are smaller; most are dropped later, because rounding leaves them no volume.
constexpr double kDust = 1e-15;

/// Joins the pieces of each instance that stays whole. Returns how many pieces became part of another.
std::uint32_t join_instances(const Pieces& pieces, const PartContacts& across, PieceGroups& groups,
                             Pacer& pacer) {
  std::uint32_t joined = 0;
  if (across.whole.empty()) return joined;
  std::vector<std::uint32_t> first_of;  // per instance: its first piece
  for (std::uint32_t p = 0; p < pieces.pieces.size(); ++p) {
    pacer.step();
    const std::uint32_t instance = across.whole[pieces.pieces[p].part];
    if (instance == kNoIndex) continue;
    if (first_of.size() <= instance) first_of.resize(instance + 1, kNoIndex);
    std::uint32_t& first = first_of[instance];
    if (first == kNoIndex) first = p;
    if (groups.of(first) == groups.of(p)) continue;
    groups.unite(first, p, pacer);
    ++joined;
  }
  return joined;
}

/// Joins pieces of different parts in the same cell. Returns how many pieces became part of another.
std::uint32_t join_in_cells(const Pieces& pieces, const PartContacts& across, PieceGroups& groups,
                            Pacer& pacer) {
  std::uint32_t joined = 0;
  for (const PieceContact& c : across.pieces) {
    pacer.step();
    if (pieces.pieces[c.of].owners[0] != pieces.pieces[c.with].owners[0]) continue;
    if (groups.of(c.of) == groups.of(c.with)) continue;
    groups.unite(c.of, c.with, pacer);
    ++joined;
  }
  return joined;
}

/// Repeatedly merges the smallest group of pieces with a neighbour and records the merged groups.
class Merging {
 public:
  Merging(const RestrictedDiagram& d, const Pieces& pieces, const SizeLimits& limits,
          const PartContacts* across, const PieceGroups& groups, const std::vector<double>& volumes,
          const Execution& execution)
      : pieces_(pieces),
        limits_(limits),
        across_(across),
        groups_(groups),
        volumes_(volumes),
        execution_(execution),
        all_(d.solid.report.volume),
        order_(d, pieces, groups, volumes, across, limits.kept_owner, execution),
        is_dust_(volumes.size(), 0) {
    for (std::uint32_t p = 0; p < volumes.size(); ++p)
      is_dust_[p] = groups.is_group(p) && volumes[p] < kDust * all_ && !order_.has_neighbor(p);
  }

  const Unions& unions() const { return unions_; }

  /// Merges groups that are too small.
  void merge_small() {
    while (is_too_small()) unite_smallest();
  }
  /// Merges groups beyond the shares of their families in SizeLimits::fragments. Returns the number of families.
  std::uint32_t merge_to_quotas() {
    std::vector<std::uint32_t> of_family, dust;  // number of groups
    for (std::uint32_t p = 0; p < volumes_.size(); ++p) {
      const std::uint32_t family = family_of(p);
      if (of_family.size() <= family) of_family.resize(family + 1, 0);
      dust.resize(of_family.size(), 0);
      (is_dust_[p] ? dust : of_family)[family] += groups_.is_group(p);
    }
    for (std::size_t k = 0; k < of_family.size(); ++k)
      if (of_family[k] == 0) of_family[k] = dust[k];  // a separate family
    for (const auto& [group, with] : unions_) --of_family[family_of(group)];
    PartQuotas quotas(
        pieces_, [&](std::uint32_t p) { return family_of(p); }, volumes_, std::move(of_family),
        limits_.fragments, execution_);
    while (quotas.any_over() && !order_.done()) {
      const std::uint32_t family = family_of(order_.smallest());
      if (!quotas.over(family))
        order_.leave_smallest();
      else if (unite_smallest())
        quotas.unite(family);
    }
    order_.take_back();
    return quotas.parts();
  }
  /// Merges groups that are too small or too many.
  void merge_rest() {
    while (is_too_small() || are_too_many()) unite_smallest();
  }
  /// Merges all groups that have a neighbour. Returns the numbers of unions after which no group is too
  /// small, ascending.
  std::vector<std::size_t> merge_all() {
    std::vector<std::size_t> ends;
    while (!order_.done()) {
      if (!is_too_small() && (ends.empty() || ends.back() < unions_.size())) ends.push_back(unions_.size());
      unite_smallest();
    }
    if (ends.empty() || ends.back() < unions_.size()) ends.push_back(unions_.size());
    return ends;
  }

 private:
  /// Returns the family of a piece: its part, or its group of parts if parts hold together. Families share
  /// the fragments.
  std::uint32_t family_of(std::uint32_t piece) const {
    const std::uint32_t part = pieces_.pieces[piece].part;
    return across_ != nullptr ? across_->group_of_part[part] : part;
  }
  bool is_too_small() {
    return !order_.done() && order_.smallest_volume() < limits_.least(all_, order_.groups());
  }
  bool are_too_many() {
    return limits_.max_fragments > 0 && order_.groups() > limits_.max_fragments && !order_.done();
  }
  bool unite_smallest() {
    const auto [group, with] = order_.unite_smallest();
    if (group == with) return false;
    unions_.emplace_back(group, with);
    return true;
  }

  const Pieces& pieces_;
  const SizeLimits& limits_;
  const PartContacts* across_;
  const PieceGroups& groups_;
  const std::vector<double>& volumes_;
  const Execution& execution_;
  const double all_;  // m³
  SmallestFirst order_;
  std::vector<char> is_dust_;  // per group
  Unions unions_;
};

/// unite_by_size() after the pieces of whole instances, and pieces of different parts in the same cell, were joined.
SizeFigures merge_by_size(const RestrictedDiagram& d, const Pieces& pieces, const SizeLimits& limits,
                          const PartContacts* across, PieceGroups& groups, const Execution& execution) {
  SizeFigures figures;
  if (!limits.any()) return figures;
  Pacer pacer(execution);
  const std::vector<double> volumes = volumes_of_groups(d, pieces, groups, execution, limits.weights);
  const double all = d.solid.report.volume;
  std::uint32_t count = 0;
  double smallest = HUGE_VAL;
  for (std::uint32_t g = 0; g < volumes.size(); ++g) {
    if (!groups.is_group(g)) continue;
    ++count;
    figures.inside_out += volumes[g] < -kInsideOut * all;
    smallest = std::fmin(smallest, volumes[g]);
  }
  // Usually nothing is too small, so contacts are not needed.
  if (limits.fragments == 0 && limits.max_fragments == 0 && limits.max_triangles == 0 &&
      smallest >= limits.least(all, count)) {
    figures.min_volume = limits.least(all, count);
    return figures;
  }

  // In every step, the smallest group merges with a neighbour: first groups that are too small, then groups
  // beyond their family's share, then groups that are too many or too small compared with the mean of the
  // rest. To meet a triangle budget, as many further unions follow as are needed.
  Merging merging(d, pieces, limits, across, groups, volumes, execution);
  merging.merge_small();
  if (limits.fragments > 0) figures.parts = merging.merge_to_quotas();
  merging.merge_rest();
  std::size_t needed = merging.unions().size();
  if (limits.max_triangles > 0) {
    const std::vector<std::size_t> ends = merging.merge_all();
    UnionTriangles triangles(d, pieces, groups, merging.unions(), execution);
    figures.fewest_triangles = triangles.after(merging.unions().size());
    if (figures.fewest_triangles <= limits.max_triangles)
      // The fewest unions that are enough; each one removes triangles.
      needed = *std::partition_point(ends.begin(), ends.end() - 1, [&](std::size_t so_many) {
        return triangles.after(so_many) > limits.max_triangles;
      });
  }
  std::vector<double> left = volumes;
  for (std::size_t k = 0; k < needed; ++k) {
    const auto [a, b] = std::minmax(merging.unions()[k].first, merging.unions()[k].second);
    groups.unite(a, b, pacer);
    left[a] += left[b];
  }
  figures.united += static_cast<std::uint32_t>(needed);
  figures.min_volume = limits.least(all, count - static_cast<std::uint32_t>(needed));
  // Every group that has a neighbour was merged. Groups without volume do not stay.
  for (std::uint32_t g = 0; g < left.size(); ++g)
    figures.alone += groups.is_group(g) && left[g] > 0 && left[g] < figures.min_volume;
  return figures;
}

}  // namespace

SizeFigures unite_by_size(const RestrictedDiagram& d, const Pieces& pieces, const SizeLimits& limits,
                          const PartContacts* across, PieceGroups& groups, const Execution& execution) {
  execution.poll();
  if (pieces.pieces.empty()) return {};
  Pacer pacer(execution);
  std::uint32_t joined = 0;
  if (across != nullptr)
    joined = join_instances(pieces, *across, groups, pacer) + join_in_cells(pieces, *across, groups, pacer);
  SizeFigures figures;
  SizeLimits others = limits;
  if (!limits.weights.empty()) {  // first the limits that concern the pieces as they are
    figures = merge_by_size(d, pieces,
                            {.min_volume = limits.min_volume,
                             .min_fraction = limits.min_fraction,
                             .kept_owner = limits.kept_owner},
                            across, groups, execution);
    others.min_volume = others.min_fraction = 0;
  }
  const SizeFigures rest = merge_by_size(d, pieces, others, across, groups, execution);
  figures.united += joined + rest.united;
  figures.inside_out = std::max(figures.inside_out, rest.inside_out);
  figures.alone = std::max(figures.alone, rest.alone);
  figures.parts = rest.parts;
  figures.min_volume = std::max(figures.min_volume, rest.min_volume);
  figures.fewest_triangles = rest.fewest_triangles;
  return figures;
}

}  // namespace fracture
