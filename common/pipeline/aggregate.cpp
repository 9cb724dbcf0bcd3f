#include "common/pipeline/aggregate.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/random.hpp"
#include "common/pipeline/cell_shares.hpp"
#include "common/pipeline/cell_touches.hpp"
#include "common/pipeline/fragment_sizes.hpp"
#include "common/sites/arithmetic.hpp"

namespace fracture {
namespace {

constexpr std::uint64_t kStream = 0x6167677265676174ull;
/// Minimum fragment size, as a multiple of the size below which fragments are united with a neighbour.
constexpr double kAboveLeast = 1.4;
/// Fragments smaller than this many mean cells consist of one cell each, which is chosen individually.
constexpr double kSmall = 1.2;
/// Minimum volume of a single cell, as a fraction of the size that it represents.
constexpr double kNearEnough = 0.75;
/// A fragment that finds no more cells counts as its wanted size if it has at least this fraction of that
/// volume.
constexpr double kMostLack = 0.6;
/// Maximum random shift of a size's rank, as a fraction of all sizes, if small sizes belong to small cells.
constexpr double kMixing = 0.12;
/// Maximum reduction, as a fraction, of the squared distance to a free cell that is surrounded by taken
/// cells.
constexpr double kNotch = 0.6;

class Aggregator {
 public:
  Aggregator(const RestrictedDiagram& d, const FractureParameters& p, std::span<const Vec3d> impacts,
             std::span<const SiteId> kept, const Execution& execution)
      : d_(d),
        p_(p),
        execution_(execution),
        pacer_(execution),
        random_(p.seed ^ kStream),
        touches_(d, pacer_),
        group_(d.diagram.dual().site_count(), kNoIndex),
        taken_(group_.size(), 0),
        seen_(group_.size(), kNoIndex) {
    const CellShares shares(d, execution);
    for (const SiteId s : ids<SiteId>(group_.size())) {
      pacer_.step(2);
      volume_.push_back(std::max(0.0, shares.volume(s)));
      double around = 0;
      for (const CellTouch& t : touches_.of(s)) around += t.area;
      around_.push_back(around);
      all_ += volume_[s];
      free_ += volume_[s] > 0;
    }
    keep(kept);
    find_ways_out(impacts);
  }

  std::vector<std::uint32_t> run() {
    if (free_ == 0) {  // each cell is its own group, except kept ones
      const auto kept =
          static_cast<std::uint32_t>(std::find(group_.begin(), group_.end(), kKept) - group_.begin());
      for (std::uint32_t s = 0; s < group_.size(); ++s) group_[s] = group_[s] == kKept ? kept : s;
      return std::move(group_);
    }
    // As many fragments as requested, or as many cells as the pattern would make outside the region.
    const double share = p_.size.fragments > 0 ? 1 : not_kept_;
    const auto wanted = static_cast<std::uint32_t>(std::nearbyint(p_.sites * share));
    const std::uint32_t count = std::min(std::max(1u, wanted), free_);
    SizesLeft sizes(count, p_.aggregation.spread, all_, kAboveLeast * p_.size.least(all_, count), pacer_);
    const std::vector<std::uint32_t> wish = ranks_by_place(sizes);
    give_small_ones(sizes);
    for (const SiteId s : ids<SiteId>(group_.size())) {
      pacer_.step();
      if (is_free(s) && volume_[s] > 0) begin(s, wish, sizes);
    }
    give_scraps_away();
    for (const SiteId s : ids<SiteId>(group_.size()))
      if (is_free(s)) group_[s] = groups_++;
    for (std::uint32_t& group : group_)
      if (group == kKept) group = groups_;
    return std::move(group_);
  }

 private:
  static constexpr std::uint32_t kScrap = kNoIndex - 1, kKept = kNoIndex - 2;

  /// Takes these cells for a group of their own, which no other cell joins.
  void keep(std::span<const SiteId> kept) {
    const double whole = all_;
    for (const SiteId s : kept) {
      take(s, kKept);
      all_ -= volume_[s];
    }
    if (!kept.empty() && whole > 0) not_kept_ = std::fmax(0, all_) / whole;
  }

  bool is_free(SiteId s) const { return group_[s] == kNoIndex; }
  const Vec3d& site(SiteId s) const { return d_.diagram.site(s); }

  void take(SiteId s, std::uint32_t group) {
    group_[s] = group;
    free_ -= volume_[s] > 0;
    for (const CellTouch& t : touches_.of(s)) taken_[t.cell] += t.area;
  }

  /// Finds, per site, the direction away from the nearest impact, in the image; none without impacts.
  void find_ways_out(std::span<const Vec3d> impacts) {
    if (impacts.empty()) return;
    const CellMap& map = d_.diagram.map();
    for (const SiteId s : ids<SiteId>(group_.size())) {
      pacer_.step(impacts.size());
      Vec3d out;
      double least = HUGE_VAL;
      for (const Vec3d& impact : impacts) {
        const Vec3d from = site(s) - (map ? map.at(site(s)).image(impact) : impact);
        if (const double square = dot(from, from); square < least) {
          least = square;
          out = from;
        }
      }
      out_.push_back(least > 0 && least < HUGE_VAL ? (1 / std::sqrt(least)) * out : Vec3d{});
    }
  }

  /// Returns, per site, the rank of the size that a fragment beginning there should have. If all cells are
  /// alike, the rank is random. If the pattern crowds some of them, larger cells get larger sizes.
  std::vector<std::uint32_t> ranks_by_place(const SizesLeft& sizes) {
    const std::uint32_t count = sizes.count();
    std::vector<std::uint32_t> wish(group_.size());
    for (std::uint32_t& rank : wish) rank = static_cast<std::uint32_t>(random_.below(count));
    if (std::holds_alternative<UniformPattern>(p_.pattern) && p_.density_from.empty()) return wish;
    struct Place {
      double size;
      SiteId cell;
      bool operator<(const Place& other) const {
        return size != other.size ? size < other.size : cell < other.cell;
      }
    };
    std::vector<Place> places;
    for (const SiteId s : ids<SiteId>(group_.size())) {
      if (!is_free(s)) continue;  // kept
      double sum = volume_[s];
      for (const CellTouch& t : touches_.of(s)) sum += volume_[t.cell];
      pacer_.step(touches_.of(s).size());
      places.push_back({sum / static_cast<double>(1 + touches_.of(s).size()), s});
    }
    sort_with_polls(execution_, places.begin(), places.end());
    const auto most_off = static_cast<std::int64_t>(kMixing * count);
    std::int64_t rank = 0;
    double below = 0, filled = sizes.part(0) * all_;
    for (const Place& place : places) {
      pacer_.step(4);
      while (below > filled && rank + 1 < count)
        filled += sizes.part(static_cast<std::uint32_t>(++rank)) * all_;
      below += volume_[place.cell];
      const auto off =
          static_cast<std::int64_t>(random_.below(static_cast<std::uint64_t>(2 * most_off + 1))) - most_off;
      wish[place.cell] =
          static_cast<std::uint32_t>(std::clamp<std::int64_t>(rank + off, 0, std::int64_t{count} - 1));
    }
    return wish;
  }

  /// Uses a single cell for each fragment that should be no larger than a cell: one of about that volume.
  void give_small_ones(SizesLeft& sizes) {
    std::vector<SiteId> by_volume;
    for (const SiteId s : ids<SiteId>(group_.size()))
      if (is_free(s) && volume_[s] > 0) by_volume.push_back(s);
    sort_with_polls(execution_, by_volume.begin(), by_volume.end(), [&](SiteId a, SiteId b) {
      return volume_[a] != volume_[b] ? volume_[a] < volume_[b] : a < b;
    });
    const double most = kSmall * all_ / std::max(1u, free_);
    auto next = by_volume.begin();
    while (sizes.left() > 1 && sizes.volume(sizes.smallest()) < most) {
      pacer_.step(16);
      const std::uint32_t rank = sizes.smallest();
      while (next != by_volume.end() && volume_[*next] < kNearEnough * sizes.volume(rank)) ++next;
      if (next == by_volume.end()) return;
      take(*next, groups_++);
      sizes.use(rank, volume_[*next]);
      group_volume_.push_back(volume_[*next]);
      ++next;
    }
  }

  void begin(SiteId s, const std::vector<std::uint32_t>& wish, SizesLeft& sizes) {
    const std::uint32_t group = groups_;
    const std::uint32_t rank = sizes.left() > 0 ? sizes.nearest_rank(wish[s]) : kNoIndex;
    const double mean = all_ / sizes.count();  // target size once all sizes are used
    const double wanted = rank != kNoIndex ? sizes.volume(rank) : p_.max_volume > 0 ? p_.max_volume : mean;
    members_.clear();
    const bool found_enough = grow(s, group, wanted, sizes.left());
    double volume = 0;
    for (const SiteId c : members_) volume += volume_[c];
    std::uint32_t fits = rank;
    bool is_scrap = rank == kNoIndex && !(p_.max_volume > 0) && volume < kMostLack * mean;
    if (rank != kNoIndex && !found_enough && volume < kMostLack * wanted) {
      fits = sizes.nearest_size(volume);
      is_scrap = volume < kMostLack * sizes.volume(fits) && sizes.left() > 1;
    }
    if (is_scrap && touches_others(group)) {  // the fragments around take it
      for (const SiteId c : members_) group_[c] = kScrap;
      scraps_.insert(scraps_.end(), members_.begin(), members_.end());
      sizes.lose(volume);
      return;
    }
    if (is_scrap)  // isolated: one group more than requested
      sizes.lose(volume);
    else if (rank != kNoIndex)
      sizes.use(fits, volume);
    group_volume_.push_back(volume);
    ++groups_;
  }

  bool touches_others(std::uint32_t group) const {
    for (const SiteId c : members_)
      for (const CellTouch& t : touches_.of(c))
        if (group_[t.cell] < groups_ && group_[t.cell] != group) return true;
    return false;
  }

  /// Takes free cells as long as this brings the volume nearer to the wanted one. Returns false if there
  /// are none left. Each of the `groups_left` groups, including this one, needs a cell.
  bool grow(SiteId seed, std::uint32_t group, double wanted, std::uint32_t groups_left) {
    std::vector<SiteId>& candidates = candidates_;
    candidates.clear();
    Vec3d moment;
    double volume = 0;
    const auto add = [&](SiteId s) {
      take(s, group);
      members_.push_back(s);
      volume += volume_[s];
      moment = moment + volume_[s] * site(s);
      for (const CellTouch& t : touches_.of(s)) {
        pacer_.step();
        if (!is_free(t.cell) || seen_[t.cell] == seed) continue;
        seen_[t.cell] = seed;
        candidates.push_back(t.cell);
      }
    };
    add(seed);
    for (;;) {
      if (free_ < groups_left) return true;
      const Vec3d middle = (1 / volume) * moment;
      std::size_t best = candidates.size();
      double least = HUGE_VAL;
      for (std::size_t k = 0; k < candidates.size(); ++k) {
        pacer_.step();
        const SiteId s = candidates[k];
        if (p_.max_volume > 0 && volume + volume_[s] > (1 - 1e-9) * p_.max_volume) continue;
        const double far = distance(s, middle);
        if (far < least || (far == least && s < candidates[best])) {
          least = far;
          best = k;
        }
      }
      if (best == candidates.size()) return candidates.empty() ? false : p_.max_volume > 0;
      const SiteId s = candidates[best];
      if (volume + 0.5 * volume_[s] > wanted) return true;
      candidates[best] = candidates.back();
      candidates.pop_back();
      add(s);
    }
  }

  /// Squared distance of a free cell from the middle of a fragment. It is reduced in the direction away
  /// from a hit, and in a notch.
  double distance(SiteId s, const Vec3d& middle) const {
    const Vec3d to = site(s) - middle;
    double square = dot(to, to);
    if (!out_.empty()) {
      const double along = dot(to, out_[s]);
      square -= (1 - 1 / (kOutwards * kOutwards)) * along * along;
    }
    const double within = around_[s] > 0 ? std::min(1.0, taken_[s] / around_[s]) : 0;
    return square * (1 - kNotch * within);
  }

  /// Adds each left-over cell to the group with which it shares the largest area.
  void give_scraps_away() {
    sort_with_polls(execution_, scraps_.begin(), scraps_.end());
    for (std::vector<SiteId> later; !scraps_.empty(); scraps_.swap(later), later.clear()) {
      for (const SiteId s : scraps_) {
        shared_.clear();
        for (const CellTouch& t : touches_.of(s)) {
          pacer_.step(4);
          const std::uint32_t g = group_[t.cell];
          if (g >= groups_) continue;
          if (p_.max_volume > 0 && group_volume_[g] + volume_[s] > (1 - 1e-9) * p_.max_volume) continue;
          shared_.emplace_back(g, t.area);
        }
        std::sort(shared_.begin(), shared_.end());
        std::uint32_t best = kNoIndex;
        double most = 0;
        for (std::size_t k = 0; k < shared_.size();) {
          const std::uint32_t g = shared_[k].first;
          double area = 0;
          for (; k < shared_.size() && shared_[k].first == g; ++k) area += shared_[k].second;
          if (area > most) {
            most = area;
            best = g;
          }
        }
        if (best == kNoIndex) {
          later.push_back(s);
          continue;
        }
        group_[s] = best;
        group_volume_[best] += volume_[s];
      }
      if (later.size() < scraps_.size()) continue;
      for (const SiteId s : later) {  // they have no neighbour with a group
        group_[s] = groups_++;
        group_volume_.push_back(volume_[s]);
      }
      later.clear();
    }
  }

  const RestrictedDiagram& d_;
  const FractureParameters& p_;
  const Execution& execution_;
  Pacer pacer_;
  Random random_;
  CellTouches touches_;
  // Per site.
  std::vector<std::uint32_t> group_;
  std::vector<double> volume_, around_;  // m³; m², area of all its caps
  std::vector<double> taken_;            // m², area of its caps to cells that are taken
  std::vector<std::uint32_t> seen_;      // the first cell of the last fragment that found it
  std::vector<Vec3d> out_;
  double all_ = 0;          // m³, without kept cells
  double not_kept_ = 1;     // share of the volume
  std::uint32_t free_ = 0;  // cells with volume
  std::uint32_t groups_ = 0;
  std::vector<double> group_volume_;
  std::vector<SiteId> members_, candidates_, scraps_;
  std::vector<std::pair<std::uint32_t, double>> shared_;
};

}  // namespace

bool is_aggregated(const SiteParameters& parameters) { return cells_per_fragment(parameters) > 1; }

std::vector<std::uint32_t> aggregate(const RestrictedDiagram& diagram, const FractureParameters& parameters,
                                     std::span<const Vec3d> impacts, std::span<const SiteId> kept,
                                     const Execution& execution) {
  return Aggregator(diagram, parameters, impacts, kept, execution).run();
}

}  // namespace fracture
