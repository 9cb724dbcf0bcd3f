#include "common/solid/seams.hpp"

#include <algorithm>
#include <array>
#include <span>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"
#include "common/solid/holes.hpp"
#include "common/solid/near_points.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {
namespace {

/// Maximum number of open half-edges tested at a vertex; usually there are two.
constexpr std::size_t kMostAtVertex = 8;
/// Steps of the search per open half-edge. Beyond this, the search ends. Each seam takes as many steps as it
/// has half-edges; steps are wasted only if many lines overlap.
constexpr std::uint64_t kMostSteps = 64;

using Loops = std::vector<std::vector<HalfEdge>>;

class SeamFinder {
 public:
  SeamFinder(const Surface& surface, double tolerance, const Execution& execution)
      : surface_(surface), tolerance2_(tolerance * tolerance), execution_(execution), pacer_(execution) {
    for_each_polled(execution, surface.twin.size(), [&](std::size_t h) {
      if (surface.twin[h] != kNoIndex) return;
      make_room(execution, open_);
      open_.push_back(static_cast<HalfEdge>(h));
    });
    taken_ = filled<std::uint8_t>(execution, open_.size(), 0);
    list_ends();
  }

  Loops run() {
    Loops loops;
    for (std::size_t k = 0; k + 1 < leaving_.size(); ++k) {
      pacer_.step();
      const VertexId tip = leaving_[k].vertex;
      if (tip == leaving_[k + 1].vertex && (k == 0 || tip != leaving_[k - 1].vertex)) find_at(tip, loops);
    }
    return loops;
  }

  /// To be called after run(), with its result. Vertices of one set of `near` count as one vertex. Returns further loops, each
  /// of which begins at two different holes that no loop of `found` has in common.
  Loops run_between_holes(const Loops& found, DisjointSets& near) {
    holes_ = singletons(execution_, open_.size());
    for (std::uint32_t k = 0; k < open_.size(); ++k) {
      pacer_.step();
      holes_.unite(k, number_of(next_along_hole(surface_, open_[k], pacer_)));
    }
    for (const std::vector<HalfEdge>& loop : found)
      for (const HalfEdge h : loop) {
        pacer_.step();
        holes_.unite(number_of(loop[0]), number_of(h));
      }
    near_ = &near;
    list_ends();
    return run();
  }

 private:
  /// A member of open_ that leaves the vertex or arrives at it.
  struct AtVertex {
    VertexId vertex;
    std::uint32_t open;
    auto operator<=>(const AtVertex&) const = default;
  };
  /// One side of a seam, starting at its tip: members of open_, and the vertex reached so far.
  struct Side {
    std::vector<std::uint32_t> open;
    VertexId end;
    Vec3d place;  ///< position of the end relative to the tip
  };

  /// The lowest of the vertices that count as the same vertex as v.
  VertexId named(VertexId v) const { return near_ == nullptr ? v : VertexId{near_->find(v)}; }
  /// Index of an open half-edge in open_.
  std::uint32_t number_of(HalfEdge h) const {
    return static_cast<std::uint32_t>(std::lower_bound(open_.begin(), open_.end(), h) - open_.begin());
  }

  void list_ends() {
    leaving_.clear();
    arriving_.clear();
    leaving_.reserve(open_.size());
    arriving_.reserve(open_.size());
    for_each_polled(execution_, open_.size(), [&](std::size_t k) {
      leaving_.push_back({named(surface_.from(open_[k])), static_cast<std::uint32_t>(k)});
      arriving_.push_back({named(surface_.to(open_[k])), static_cast<std::uint32_t>(k)});
    });
    sort_with_polls(execution_, leaving_.begin(), leaving_.end());
    sort_with_polls(execution_, arriving_.begin(), arriving_.end());
    steps_left_ = kMostSteps * open_.size();
  }

  static std::span<const AtVertex> at(const std::vector<AtVertex>& list, VertexId v) {
    const auto first = std::lower_bound(list.begin(), list.end(), AtVertex{v, 0});
    auto last = first;
    while (last != list.end() && last->vertex == v && last - first < std::ptrdiff_t{kMostAtVertex}) ++last;
    return {first, last};
  }
  Vec3d from_tip(VertexId v) const {
    return to_double(surface_.positions[v]) - to_double(surface_.positions[tip_]);
  }
  /// Whether the nearer of the two points is within the tolerance of the segment from the tip to the farther
  /// one.
  bool on_one_line(const Vec3d& a, const Vec3d& b) const {
    const Vec3d n = cross(a, b);
    return dot(a, b) > 0 && dot(n, n) <= tolerance2_ * std::max(dot(a, a), dot(b, b));
  }

  void find_at(VertexId tip, Loops& loops) {
    tip_ = tip;
    for (const AtVertex& arrives : at(arriving_, tip))
      for (const AtVertex& leaves : at(leaving_, tip)) {
        if (taken_[arrives.open] || taken_[leaves.open]) continue;
        if (near_ != nullptr && holes_.find(arrives.open) == holes_.find(leaves.open)) continue;
        back_.open.clear();
        front_.open.clear();
        add(back_, arrives.open, named(surface_.from(open_[arrives.open])));
        add(front_, leaves.open, named(surface_.to(open_[leaves.open])));
        if (!follow()) continue;
        // Go away from the tip against the half-edges that arrive at it, and back against the others.
        std::vector<HalfEdge>& loop = loops.emplace_back();
        for (const std::uint32_t k : back_.open) loop.push_back(open_[k]);
        for (auto k = front_.open.rbegin(); k != front_.open.rend(); ++k) loop.push_back(open_[*k]);
        for (const Side* side : {&back_, &front_})
          for (const std::uint32_t k : side->open) taken_[k] = 1;
      }
  }

  void add(Side& side, std::uint32_t open, VertexId end) {
    side.open.push_back(open);
    side.end = end;
    side.place = from_tip(end);
  }

  /// Extends the shorter side until both reach the same vertex. Returns false if a side cannot continue along
  /// the line.
  bool follow() {
    while (on_one_line(back_.place, front_.place)) {
      if (back_.end == front_.end) return true;
      const bool back = dot(back_.place, back_.place) <= dot(front_.place, front_.place);
      if (!lengthen(back ? back_ : front_, back ? front_ : back_, back)) return false;
    }
    return false;
  }

  bool lengthen(Side& side, const Side& other, bool back) {
    for (const AtVertex& next : at(back ? arriving_ : leaving_, side.end)) {
      if (steps_left_ == 0) return false;
      --steps_left_;
      pacer_.step(4);
      const VertexId end = named(back ? surface_.from(open_[next.open]) : surface_.to(open_[next.open]));
      const Vec3d place = from_tip(end);
      if (taken_[next.open] || !(dot(place, place) > dot(side.place, side.place)) ||
          !on_one_line(place, other.place))
        continue;
      add(side, next.open, end);
      return true;
    }
    return false;
  }

  const Surface& surface_;
  double tolerance2_;
  const Execution& execution_;
  Pacer pacer_;
  std::vector<HalfEdge> open_;                // ascending
  std::vector<std::uint8_t> taken_;           // per member of open_
  std::vector<AtVertex> leaving_, arriving_;  // by vertex
  std::uint64_t steps_left_ = 0;
  VertexId tip_ = kNoVertex;
  Side back_, front_;
  DisjointSets* near_ = nullptr;  // null: each vertex counts as itself
  DisjointSets holes_;            // of open_: one set per hole
};

/// Unites the vertices at which consecutive half-edges of the loop do not meet. Does nothing if two of them are farther apart
/// than the tolerance, or if the loop is a crack between two edges.
void close_gaps(const Surface& surface, const std::vector<HalfEdge>& loop, double tolerance,
                DisjointSets& merged, Pacer& pacer) {
  if (loop.size() == 2) return;  // weld_tolerant() and offer_welding() decide about cracks
  std::vector<std::array<VertexId, 2>> gaps;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    pacer.step();
    const VertexId end = surface.from(loop[i]), start = surface.to(loop[i + 1 == loop.size() ? 0 : i + 1]);
    if (end == start) continue;
    if (!(length(to_double(surface.positions[end]) - to_double(surface.positions[start])) <= tolerance))
      return;
    gaps.push_back({end, start});
  }
  for (const auto& [end, start] : gaps) merged.unite(end, start);
}

std::vector<VertexId> open_ends(const Surface& surface, const Execution& execution) {
  std::vector<VertexId> ends;
  for_each_polled(execution, surface.twin.size(), [&](std::size_t h) {
    if (surface.twin[h] != kNoIndex) return;
    make_room(execution, ends, 2);
    ends.push_back(surface.from(static_cast<HalfEdge>(h)));
    ends.push_back(surface.to(static_cast<HalfEdge>(h)));
  });
  sort_with_polls(execution, ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  return ends;
}

}  // namespace

std::vector<std::vector<HalfEdge>> find_seams(const Surface& surface, double tolerance,
                                              const Execution& execution) {
  return SeamFinder(surface, tolerance, execution).run();
}

void weld_ends_of_seams(Surface& surface, double tolerance, SolidReport& report, const Execution& execution) {
  if (!(tolerance > 0)) return;
  DisjointSets near = singletons(execution, surface.positions.size());
  unite_near(surface.positions, open_ends(surface, execution), tolerance, near, execution);
  if (near.set_count() == surface.positions.size()) return;
  SeamFinder finder(surface, tolerance, execution);
  const Loops found = finder.run(), more = finder.run_between_holes(found, near);
  if (more.empty()) return;
  DisjointSets merged = singletons(execution, surface.positions.size());
  Pacer pacer(execution);
  for (const std::vector<HalfEdge>& loop : more) close_gaps(surface, loop, tolerance, merged, pacer);

  // A triangle between two of these vertices would collapse, so they stay.
  std::vector<std::uint8_t> stays = filled<std::uint8_t>(execution, surface.positions.size(), 0);
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    const Triangle& corners = surface.triangles[t];
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t root = merged.find(corners[k]);
      if (root == merged.find(corners[(k + 1) % 3])) stays[root] = 1;
    }
  });
  const auto target = [&](VertexId v) {
    const VertexId root{merged.find(v)};
    return stays[root] ? v : root;
  };
  std::uint64_t count = 0;
  for (const VertexId v : ids<VertexId>(surface.positions.size())) {
    pacer.step();
    if (target(v) == v || count++ > 0) continue;
    report.add_sample("welded_tolerant", surface.positions[v]);
  }
  if (count == 0) return;
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    for (VertexId& v : surface.triangles[t]) v = target(v);
  });
  report.welded_tolerant += count;
}

}  // namespace fracture::solid_detail
