#include "common/rough/crossings.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

std::vector<std::uint32_t> numbers_of(const std::vector<char>& flags) {
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t k = 0; k < flags.size(); ++k)
    if (flags[k]) numbers.push_back(k);
  return numbers;
}

/// Counts pairs, which come by the million. Updates the shared count and polls once per thousand pairs.
class PairCount {
 public:
  PairCount(std::atomic<std::uint64_t>& all, std::uint64_t most, const Execution& execution)
      : all_(all), most_(most), execution_(execution) {}
  ~PairCount() { all_.fetch_add(mine_, std::memory_order_relaxed); }
  PairCount(const PairCount&) = delete;
  PairCount& operator=(const PairCount&) = delete;
  /// Returns false if there were too many.
  bool one_more() {
    if (++mine_ == kAtOnce) {
      all_.fetch_add(std::exchange(mine_, 0), std::memory_order_relaxed);
      execution_.poll();
      good_ = all_.load(std::memory_order_relaxed) <= most_;
    }
    return good_;
  }

 private:
  static constexpr std::uint64_t kAtOnce = 4096;
  std::atomic<std::uint64_t>& all_;
  const std::uint64_t most_;
  const Execution& execution_;
  std::uint64_t mine_ = 0;
  bool good_ = true;
};

}  // namespace

Crossings::Crossings(const CapSurface& caps, const SurfaceTree& outside, double tolerance,
                     const Execution& execution)
    : caps_(caps), outside_(outside), tolerance_(tolerance), seen_(numbers_of(caps.seen)), tree_([&] {
        Pacer pacer(execution);
        now_.reserve(seen_.size());
        boxes_.reserve(seen_.size());
        region_.reserve(seen_.size());
        std::vector<std::uint32_t> begin{0};
        std::uint32_t region = 0;
        for (std::uint32_t k = 0; k < seen_.size(); ++k) {
          pacer.step();
          for (; caps.region_begin[region + 1] <= seen_[k]; ++region) begin.push_back(k);
          region_.push_back(region);
          now_.push_back(as_it_is(k));
          boxes_.push_back(box_of(now_.back().corners));
        }
        begin.push_back(static_cast<std::uint32_t>(seen_.size()));
        return BoxTree(boxes_, begin, execution);
      }()) {}

PlaneTriangle Crossings::as_it_is(std::uint32_t k) const {
  const auto at = [&](std::size_t corner) { return caps_.points[vertices(k)[corner] - caps_.first]; };
  return PlaneTriangle({at(0), at(1), at(2)});
}

bool Crossings::is_moved(std::uint32_t k) const {
  const auto& v = vertices(k);
  return caps_.moved[v[0] - caps_.first] || caps_.moved[v[1] - caps_.first] ||
         caps_.moved[v[2] - caps_.first];
}

bool Crossings::pair_crosses(std::uint32_t i, std::uint32_t j) const {
  if (region_[i] == region_[j]) return false;
  // The plane test comes first, because few pairs pass it and it reads the least memory.
  if (!cross_each_other(now_[i], now_[j], tolerance_)) return false;
  int shared = 0;
  for (const CutVertexId v : vertices(i))
    for (const CutVertexId w : vertices(j))
      shared += caps_.place[v - caps_.first] == caps_.place[w - caps_.first];
  return shared < 2 && (is_moved(i) || is_moved(j));
}

/// Whether the triangle can reach the outer surface. Every point of it is within 0.58 of its longest edge
/// from a corner.
bool Crossings::may_leave_surface(std::uint32_t k) const {
  if (!is_moved(k)) return false;
  const PlaneTriangle& t = now_[k];
  double longest = 0, from_surface = HUGE_VAL;
  for (std::size_t corner = 0; corner < 3; ++corner) {
    longest = std::max(longest, length(t.corners[(corner + 1) % 3] - t.corners[corner]));
    const std::size_t v = vertices(k)[corner] - caps_.first;
    from_surface = std::min(from_surface, caps_.surface[v] - length(t.corners[corner] - caps_.flat[v]));
  }
  return from_surface < 0.58 * longest;
}

/// Calls leaves(k) for each of the triangles, all of one region, that passes through the outer surface.
template <class Leaves>
void Crossings::each_leaving(std::span<const std::uint32_t> triangles, SurfaceBeside& beside,
                             const Leaves& leaves) const {
  Box all;
  beside.may_leave.clear();
  for (const std::uint32_t k : triangles)
    if (may_leave_surface(k)) {
      beside.may_leave.push_back(k);
      all.add(boxes_[k]);
    }
  if (beside.may_leave.empty()) return;
  beside.triangles.clear();
  beside.boxes.clear();
  const bool by_list = outside_.triangles() <= kFewOutside;
  if (by_list)
    outside_.each_near(all, [&](std::uint32_t other) {
      if (beside.triangles.size() > kFewBeside) return;
      beside.triangles.push_back(other);
      beside.boxes.push_back(box_of(outside_.corners(other)));
    });
  for (const std::uint32_t k : beside.may_leave) {
    const PlaneTriangle& t = now_[k];
    bool left = false;
    const auto look = [&](std::uint32_t other) {
      if (!left && is_parted(t, outside_.corners(other), tolerance_))
        left = cross_each_other(t, PlaneTriangle(outside_.corners(other)), tolerance_);
    };
    if (!by_list || beside.triangles.size() > kFewBeside) {
      outside_.each_near(boxes_[k], look);
    } else {
      for (std::size_t n = 0; n < beside.triangles.size(); ++n)
        if (beside.boxes[n].intersects(boxes_[k])) look(beside.triangles[n]);
    }
    if (left) leaves(k);
  }
}

std::optional<std::uint64_t> Crossings::find(const std::vector<char>& suspects, std::vector<char>& crossing,
                                             const Execution& execution) {
  const auto n = static_cast<std::uint32_t>(seen_.size());
  std::vector<std::uint32_t> changed;
  for (std::uint32_t k = 0; k < n; ++k) {
    if (looked_ && !suspects[seen_[k]]) continue;
    if (looked_) {
      now_[k] = as_it_is(k);
      boxes_[k] = box_of(now_[k].corners);
    }
    changed.push_back(k);
  }
  if (looked_) tree_.refit(boxes_, execution);
  // If few triangles have moved, each of them queries the tree; otherwise, the tree is tested against itself.
  std::vector<char> asks(n, 0);
  std::size_t asking = 0;
  for (const std::uint32_t k : changed) {
    asks[k] = is_moved(k) || looked_;
    asking += asks[k];
  }
  const bool one_by_one = asking < n / kFewMoved;

  std::atomic<std::uint64_t> count{0}, pairs{pairs_};
  const std::uint64_t most = kMostPairs * n;
  crossing.assign(caps_.triangles.size(), 0);
  const auto mark = [&](std::uint32_t i, std::uint32_t j) {
    for (const std::uint32_t k : {i, j})
      std::atomic_ref(crossing[seen_[k]]).store(1, std::memory_order_relaxed);
    count.fetch_add(1, std::memory_order_relaxed);
  };
  const auto look = [&](std::uint32_t i, std::uint32_t j, PairCount& budget) {
    if ((asks[i] || asks[j]) && budget.one_more() && pair_crosses(i, j)) mark(i, j);
  };
  if (!one_by_one) {
    const std::vector<BoxTree::Task> tasks = tree_.pair_tasks(1024);
    parallel_for(execution, tasks.size(), 16, [&](std::size_t begin, std::size_t end) {
      PairCount budget(pairs, most, execution);
      for (std::size_t k = begin; k < end && pairs.load(std::memory_order_relaxed) <= most; ++k)
        tree_.each_pair(tasks[k], [&](std::uint32_t i, std::uint32_t j) { look(i, j, budget); });
    });
  }
  parallel_for(execution, changed.size(), 256, [&](std::size_t begin, std::size_t end) {
    PairCount budget(pairs, most, execution);
    SurfaceBeside beside;
    for (std::size_t c = begin, next = begin; c < end && pairs.load(std::memory_order_relaxed) <= most;
         c = next) {
      for (; next < end && region_[changed[next]] == region_[changed[c]]; ++next) {
        const std::uint32_t k = changed[next];
        if (!one_by_one || !asks[k]) continue;
        tree_.each_overlapping(boxes_[k], [&](std::uint32_t other) {
          if (other != k && (!asks[other] || k < other)) look(k, other, budget);
        });
      }
      each_leaving({changed.data() + c, next - c}, beside, [&](std::uint32_t k) { mark(k, k); });
    }
  });
  looked_ = true;
  pairs_ = pairs;
  if (pairs_ > most) return std::nullopt;
  return count.load();
}

}  // namespace fracture
