#include "common/solid/nonmanifold.hpp"

#include <algorithm>
#include <atomic>

#include "common/base/pacer.hpp"
#include "common/solid/float_predicates.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {
namespace {

/// Sorts the uses of one edge by angle around it (see pair_nonmanifold_edges).
class AngleOrder {
 public:
  AngleOrder(const Surface& surface, VertexId a, VertexId b, std::span<const EdgeUse> uses, Pacer& pacer)
      : surface_(surface), a_(surface.positions[a]), b_(surface.positions[b]) {
    // The reference direction is that of the first apex that is not on the edge's line.
    for (const EdgeUse& use : uses) {
      pacer.step(16);
      reference_ = surface.positions[surface.apex(use.half_edge())];
      for (axis_ = 0; axis_ < 3; ++axis_)
        if ((side_ = flat_side(reference_)) != 0) return;
    }
    axis_ = 0;
  }

  struct Item {
    EdgeUse use;
    Vec3f apex;
    int sector;  ///< 0: on the line or at the reference angle, 1: (0, π), 2: π, 3: (π, 2π)
  };
  Item item(const EdgeUse& use) const {
    const Vec3f apex = surface_.positions[surface_.apex(use.half_edge())];
    const int turn = sign_orient3d(a_, b_, reference_, apex);
    return {use, apex, turn > 0 ? 1 : turn < 0 ? 3 : flat_side(apex) == -side_ && side_ != 0 ? 2 : 0};
  }
  bool operator()(const Item& x, const Item& y) const {
    if (x.sector != y.sector) return x.sector < y.sector;
    if (x.sector == 1 || x.sector == 3) {
      const int turn = sign_orient3d(a_, b_, x.apex, y.apex);
      if (turn != 0) return turn > 0;
    }
    if (x.use.backward() != y.use.backward()) return !x.use.backward();
    return x.use.bits < y.use.bits;
  }

 private:
  int flat_side(const Vec3f& p) const {
    return sign_orient2d(drop_axis(a_, axis_), drop_axis(b_, axis_), drop_axis(p, axis_));
  }
  const Surface& surface_;
  Vec3f a_, b_, reference_;
  int axis_ = 0, side_ = 0;
};

/// Per triangle: whether its patch (triangles connected by clean edges) has an open edge.
std::vector<std::uint8_t> find_sheets(const Surface& surface, const EdgeTable& edges,
                                      const Execution& execution) {
  const std::size_t count = surface.triangles.size();
  DisjointSets patches = singletons(execution, count);
  std::vector<std::uint8_t> open = filled<std::uint8_t>(execution, count, 0);
  edges.for_each(execution, [&](VertexId, VertexId, std::span<const EdgeUse> uses) {
    if (uses.size() == 2) patches.unite(uses[0].half_edge() / 3, uses[1].half_edge() / 3);
  });
  edges.for_each(execution, [&](VertexId, VertexId, std::span<const EdgeUse> uses) {
    if (uses.size() == 1) open[patches.find(uses[0].half_edge() / 3)] = 1;
  });
  for_each_polled(execution, count, [&](std::size_t t) { open[t] = open[patches.find(TriangleId{t})]; });
  return open;
}

}  // namespace

bool drop_duplicates(Surface& surface, const EdgeTable& edges, SolidReport& report,
                     const Execution& execution) {
  // Copies matter only for triangles with an edge that is not clean. A pair of opposite copies with three
  // clean edges is a closed shell without volume, and is dropped with such shells.
  struct Entry {
    Triangle key;
    std::uint32_t odd;  // parity of the permutation that sorts the corners, which is the orientation
    TriangleId triangle;
    auto operator<=>(const Entry&) const = default;
  };
  const std::size_t count = surface.triangles.size();
  std::vector<std::uint8_t> candidate = filled<std::uint8_t>(execution, count, 0);
  edges.for_each(execution, [&](VertexId, VertexId, std::span<const EdgeUse> uses) {
    if (uses.size() == 1 || (uses.size() == 2 && uses[0].backward() != uses[1].backward())) return;
    for (const EdgeUse& use : uses) candidate[use.half_edge() / 3] = 1;
  });
  std::vector<Entry> entries;
  for_each_polled(execution, count, [&](std::size_t t) {
    if (!candidate[t]) return;
    Triangle key = surface.triangles[t];
    const bool even = (key[0] < key[1] && key[1] < key[2]) || (key[1] < key[2] && key[2] < key[0]) ||
                      (key[2] < key[0] && key[0] < key[1]);
    std::sort(key.begin(), key.end());
    make_room(execution, entries);
    entries.push_back({key, even ? 0u : 1u, TriangleId{t}});
  });
  if (entries.empty()) return false;
  sort_with_polls(execution, entries.begin(), entries.end());

  Pacer pacer(execution);
  std::vector<std::uint8_t> doomed = filled<std::uint8_t>(execution, count, 0);
  std::size_t dropped = 0;
  std::vector<std::uint32_t> group_of = filled(execution, count, kNoIndex);
  std::vector<std::array<TriangleId, 2>> groups;  // doubled triangles, lower id first
  std::vector<TriangleId> copies;
  for (std::size_t i = 0; i < entries.size();) {
    std::size_t j = i + 1;
    while (j < entries.size() && entries[j].key == entries[i].key) ++j;
    pacer.step(4 * (j - i));
    copies.clear();
    for (std::size_t k = i; k < j; ++k) copies.push_back(entries[k].triangle);
    const bool both_ways = entries[i].odd != entries[j - 1].odd;
    std::array<TriangleId, 2> kept{copies.front(),
                                   copies.size() > 1 ? (both_ways ? copies.back() : copies[1]) : kNoTriangle};
    if (kept[1] < kept[0]) std::swap(kept[0], kept[1]);
    if (copies.size() % 2 == 1) kept = {*std::min_element(copies.begin(), copies.end()), kNoTriangle};
    for (const TriangleId t : copies)
      if (t != kept[0] && t != kept[1]) doomed[t] = 1, ++dropped;
    if (kept[1] != kNoTriangle) {
      group_of[kept[0]] = group_of[kept[1]] = static_cast<std::uint32_t>(groups.size());
      groups.push_back(kept);
    }
    i = j;
  }
  if (!groups.empty()) {
    DisjointSets patches = singletons(execution, groups.size());
    std::vector<std::uint32_t> here;
    const auto groups_at = [&](std::span<const EdgeUse> uses) {
      here.clear();
      for (const EdgeUse& use : uses)
        if (const std::uint32_t g = group_of[use.half_edge() / 3]; g != kNoIndex) here.push_back(g);
      sort_with_polls(execution, here.begin(), here.end());
      here.erase(std::unique(here.begin(), here.end()), here.end());
    };
    edges.for_each(execution, [&](VertexId, VertexId, std::span<const EdgeUse> uses) {
      if (uses.size() < 2) return;
      groups_at(uses);
      for (std::size_t k = 1; k < here.size(); ++k) patches.unite(here[0], here[k]);
    });
    std::vector<std::int64_t> odd_with_one(groups.size(), 0), odd_with_both(groups.size(), 0);
    edges.for_each(execution, [&](VertexId, VertexId, std::span<const EdgeUse> uses) {
      if (uses.size() < 2) return;
      groups_at(uses);
      if (here.empty()) return;
      std::size_t kept = 0;
      for (const EdgeUse& use : uses) kept += !doomed[use.half_edge() / 3];
      odd_with_both[patches.find(here[0])] += kept % 2;
      odd_with_one[patches.find(here[0])] += (kept - here.size()) % 2;
    });
    for (std::uint32_t g = 0; g < groups.size(); ++g) {
      pacer.step();
      const std::uint32_t patch = patches.find(g);
      if (odd_with_one[patch] > odd_with_both[patch]) continue;
      doomed[groups[g][1]] = 1;
      ++dropped;
    }
  }
  if (dropped == 0) return false;
  const auto first = static_cast<TriangleId>(std::find(doomed.begin(), doomed.end(), 1) - doomed.begin());
  report.add_sample("duplicates_dropped", surface.positions[surface.triangles[first][0]]);
  report.duplicates_dropped += dropped;
  surface.remove(doomed, execution);
  return true;
}

std::size_t pair_nonmanifold_edges(Surface& surface, const EdgeTable& edges, const Execution& execution) {
  std::size_t nonmanifold = 0;
  std::vector<std::uint8_t> on_sheet;  // per triangle; computed for the first unbalanced edge
  std::vector<AngleOrder::Item> ring;
  std::vector<EdgeUse> entered;
  Pacer pacer(execution);
  const auto glue = [&](bool with_sheets) {
    entered.clear();
    for (int lap = 0; lap < 2; ++lap)
      for (const AngleOrder::Item& item : ring) {
        pacer.step();
        const HalfEdge h = item.use.half_edge();
        if (surface.twin[h] != kNoIndex || (!with_sheets && on_sheet[h / 3])) continue;
        if (item.use.backward()) {
          if (lap == 0) entered.push_back(item.use);
        } else if (!entered.empty()) {
          surface.twin[h] = entered.back().half_edge();
          surface.twin[entered.back().half_edge()] = h;
          entered.pop_back();
        }
      }
  };
  edges.for_each(execution, [&](VertexId a, VertexId b, std::span<const EdgeUse> uses) {
    if (uses.size() <= 2) return;
    ++nonmanifold;
    const AngleOrder order(surface, a, b, uses, pacer);
    ring.clear();
    std::size_t backward = 0;
    for (const EdgeUse& use : uses) {
      pacer.step(16);  // exact predicates
      ring.push_back(order.item(use));
      backward += use.backward();
    }
    sort_with_polls(execution, ring.begin(), ring.end(), order);
    if (2 * backward != uses.size()) {
      if (on_sheet.empty()) on_sheet = find_sheets(surface, edges, execution);
      glue(false);
    }
    glue(true);
  });
  return nonmanifold;
}

namespace {

/// Whether every vertex has a single, closed fan of triangles. If so, the fans around one corner of each
/// vertex contain all corners.
bool have_one_fan_each(const Surface& surface, const Execution& execution) {
  constexpr std::size_t kAtOnce = 16384;
  // Per vertex: any half-edge that leaves it. It does not matter which thread writes last.
  std::vector<HalfEdge> leaving = filled(execution, surface.positions.size(), kNoIndex);
  parallel_for(execution, surface.triangles.size(), kAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t)
      for (HalfEdge k = 0; k < 3; ++k)
        std::atomic_ref(leaving[surface.triangles[t][k]])
            .store(static_cast<HalfEdge>(3 * t + k), std::memory_order_relaxed);
  });
  std::atomic<std::size_t> corners{0};
  parallel_for(execution, leaving.size(), kAtOnce, [&](std::size_t begin, std::size_t end) {
    Pacer pacer(execution);
    std::size_t mine = 0;
    for (std::size_t v = begin; v < end; ++v) {
      const HalfEdge start = leaving[v];
      if (start == kNoIndex) continue;
      HalfEdge h = start;
      do {
        pacer.step();
        ++mine;
        h = surface.twin[previous(h)];
      } while (h != kNoIndex && h != start);
      if (h == kNoIndex) return;  // its corners are not counted, so the sum will be too small
    }
    corners += mine;
  });
  return corners == 3 * surface.triangles.size();
}

}  // namespace

std::size_t split_umbrellas(Surface& surface, const Execution& execution) {
  if (have_one_fan_each(surface, execution)) return 0;
  const std::size_t original = surface.positions.size();
  std::vector<std::uint8_t> corner_done = filled<std::uint8_t>(execution, 3 * surface.triangles.size(), 0),
                            vertex_seen = filled<std::uint8_t>(execution, original, 0);
  Pacer pacer(execution);
  for (HalfEdge start = 0; start < corner_done.size(); ++start) {
    if (start % 65536 == 0) execution.poll();
    if (corner_done[start]) continue;
    const VertexId old = surface.from(start);
    VertexId id = old;
    if (vertex_seen[old]) {
      id = VertexId{surface.positions.size()};
      const Vec3f position = surface.positions[old];
      make_room(execution, surface.positions);
      surface.positions.push_back(position);
    }
    vertex_seen[old] = 1;
    const auto visit = [&](HalfEdge h) {
      pacer.step();
      corner_done[h] = 1;
      if (id != old) surface.triangles[h / 3][h % 3] = id;
    };
    visit(start);
    HalfEdge h = surface.twin[previous(start)];
    for (; h != kNoIndex && h != start; h = surface.twin[previous(h)]) visit(h);
    if (h == start) continue;
    // An open fan: continue in the other direction.
    for (HalfEdge back = surface.twin[start]; back != kNoIndex; back = surface.twin[next(back)])
      visit(next(back));
  }
  return surface.positions.size() - original;
}

}  // namespace fracture::solid_detail
