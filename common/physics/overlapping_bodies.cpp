#include "common/physics/overlapping_bodies.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/scratch.hpp"
#include "common/bvh/box_tree.hpp"
#include "common/physics/hull_overlap.hpp"

namespace fracture {
namespace {

struct MeasureScratch {
  HullOverlap overlap;
  std::vector<Vec3d> a, b;
  std::size_t bytes() const { return overlap.bytes() + bytes_of_vectors(a, b); }
  void release() {
    overlap.release();
    release_vectors(a, b);
  }
};

struct HullOfBody {
  std::uint32_t body, hull;
};

/// Measures the overlap of hulls of two bodies.
class Measure {
 public:
  Measure(const Bodies& bodies, const Execution& execution) : bodies_(bodies), pacer_(execution) {}

  Overlap of(const HullOfBody& x, const HullOfBody& y) {
    const auto [a, b] = x.body < y.body ? std::pair(x, y) : std::pair(y, x);
    MeasureScratch& scratch = thread_scratch<MeasureScratch>();
    const Vec3d& origin = bodies_.fragments[a.body]->pivot;  // keeps precision far from the world's
    place(a, origin, scratch.a);
    place(b, origin, scratch.b);
    const HullDepth found = scratch.overlap.measure(scratch.a, scratch.b, pacer_);
    return {{a.body, b.body}, found.depth, found.normal, a.hull, b.hull};
  }

 private:
  void place(const HullOfBody& of, const Vec3d& origin, std::vector<Vec3d>& out) const {
    const Vec3d shift = bodies_.fragments[of.body]->pivot - origin;
    out.clear();
    for (const Vec3f& p : bodies_.hulls[of.body]->hulls[of.hull].points) out.push_back(shift + to_double(p));
  }

  const Bodies& bodies_;
  Pacer pacer_;
};

Box box_of(const Bodies& bodies, std::uint32_t body, std::uint32_t hull) {
  Box box;
  for (const Vec3f& p : bodies.hulls[body]->hulls[hull].points)
    box.add(bodies.fragments[body]->pivot + to_double(p));
  return box;
}

/// Keeps the deepest overlap of each pair, ascending.
void keep_deepest(std::vector<Overlap>& all, const Execution& execution) {
  sort_with_polls(execution, all.begin(), all.end(), [](const Overlap& x, const Overlap& y) {
    if (x.pair != y.pair) return x.pair < y.pair;
    if (x.depth != y.depth) return x.depth > y.depth;
    return std::pair(x.hull_a, x.hull_b) < std::pair(y.hull_a, y.hull_b);
  });
  all.erase(std::unique(all.begin(), all.end(),
                        [](const Overlap& x, const Overlap& y) { return x.pair == y.pair; }),
            all.end());
}

/// The box of all hulls of a body.
Box box_of(const Bodies& bodies, std::uint32_t body) {
  Box box;
  for (std::uint32_t h = 0; h < bodies.hulls[body]->hulls.size(); ++h) {
    const Box hull = box_of(bodies, body, h);
    box.add(hull.min);
    box.add(hull.max);
  }
  return box;
}

/// Pairs of fragments that have pieces of the same cell and whose boxes meet, ascending.
std::vector<BodyPair> sharing_a_cell(const Bodies& bodies, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<std::optional<Box>> box(bodies.size());           // of those that share a cell
  std::vector<std::pair<std::uint32_t, std::uint32_t>> owners;  // site, body
  for (std::uint32_t k = 0; k < bodies.size(); ++k) {
    pacer.step(8);
    for (const std::uint32_t site : bodies.fragments[k]->sites) owners.emplace_back(site, k);
  }
  sort_with_polls(execution, owners.begin(), owners.end());
  std::vector<BodyPair> pairs;
  for (std::size_t first = 0, last = 0; first < owners.size(); first = last) {
    while (last < owners.size() && owners[last].first == owners[first].first) ++last;
    if (last - first < 2) continue;
    std::vector<Box> boxes;
    for (std::size_t k = first; k < last; ++k) {
      pacer.step(4);
      const std::uint32_t body = owners[k].second;
      if (!box[body]) box[body] = box_of(bodies, body);
      boxes.push_back(*box[body]);
    }
    const BoxTree tree(boxes, execution);
    for (const BoxTree::Task& task : tree.pair_tasks(1))
      tree.each_pair(task, [&](std::uint32_t i, std::uint32_t j) {
        pacer.step();
        const auto [a, b] = std::minmax(owners[first + i].second, owners[first + j].second);
        if (a != b) pairs.push_back({a, b});
      });
  }
  sort_with_polls(execution, pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

void measure_pairs(const Bodies& bodies, std::span<const BodyPair> pairs, std::vector<Overlap>& found,
                   const Execution& execution) {
  std::vector<Overlap> all(pairs.size());
  parallel_for(execution, pairs.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) all[k] = deepest_overlap(bodies, pairs[k], execution);
  });
  for (const Overlap& overlap : all)
    if (overlap.depth > 0) found.push_back(overlap);
}

/// Measures pairs of bodies in different groups. If there is only one group, measures all of its pairs.
void measure_all(const Bodies& bodies, const std::vector<std::vector<std::uint32_t>>& groups,
                 std::vector<Overlap>& found, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<HullOfBody> hulls;
  std::vector<Box> boxes;
  std::vector<std::uint32_t> begin{0};
  for (const std::vector<std::uint32_t>& group : groups) {
    for (const std::uint32_t body : group)
      for (std::uint32_t h = 0; h < bodies.hulls[body]->hulls.size(); ++h) {
        pacer.step(bodies.hulls[body]->hulls[h].points.size() / 4);
        hulls.push_back({body, h});
        boxes.push_back(box_of(bodies, body, h));
      }
    begin.push_back(static_cast<std::uint32_t>(hulls.size()));
  }
  const BoxTree tree = groups.size() > 1 ? BoxTree(boxes, begin, execution) : BoxTree(boxes, execution);
  constexpr std::size_t kTasks = 64;
  const std::vector<BoxTree::Task> tasks = tree.pair_tasks(kTasks);
  std::vector<std::vector<Overlap>> of_task(tasks.size());
  parallel_for(execution, tasks.size(), 1, [&](std::size_t first, std::size_t last) {
    Measure measure(bodies, execution);
    for (std::size_t k = first; k < last; ++k)
      tree.each_pair(tasks[k], [&](std::uint32_t i, std::uint32_t j) {
        if (hulls[i].body == hulls[j].body) return;
        const Overlap overlap = measure.of(hulls[i], hulls[j]);
        if (overlap.depth > 0) of_task[k].push_back(overlap);
      });
  });
  for (const std::vector<Overlap>& some : of_task) found.insert(found.end(), some.begin(), some.end());
}

/// Index of a part's frame.
std::size_t frame_of(const CellMap& map, std::uint32_t part) {
  if (!map) return 0;
  return static_cast<std::size_t>(&map.of_part(part) - map.frames().data());
}

/// Whether hulls may extend beyond the fragment's cells, as the hulls of a whole part in several cells do (divided_hulls.hpp).
bool may_leave_its_cells(const Fragment& f) { return f.caps.empty() && f.bodies.size() > 1; }

/// Index of the frame that contains all cells of a fragment; kNoIndex if there are several frames.
std::size_t only_frame_of(const CellMap& map, const Fragment& f) {
  const std::size_t frame = frame_of(map, f.part);
  const bool is_only = std::all_of(f.part_cells.begin(), f.part_cells.end(),
                                   [&](const PartCell& cell) { return frame_of(map, cell.part) == frame; });
  return is_only ? frame : kNoIndex;
}

}  // namespace

Overlap deepest_overlap(const Bodies& bodies, const BodyPair& pair, const Execution& execution) {
  Measure measure(bodies, execution);
  const auto boxes_of = [&](std::uint32_t body) {
    std::vector<Box> boxes;
    for (std::uint32_t h = 0; h < bodies.hulls[body]->hulls.size(); ++h)
      boxes.push_back(box_of(bodies, body, h));
    return boxes;
  };
  const std::vector<Box> of_a = boxes_of(pair.a), of_b = boxes_of(pair.b);
  Overlap deepest;
  deepest.pair = pair;
  const auto compare = [&](std::uint32_t x, std::uint32_t y) {
    const Overlap overlap = measure.of({pair.a, x}, {pair.b, y});
    const bool is_earlier = std::pair(x, y) < std::pair(deepest.hull_a, deepest.hull_b);
    if (overlap.depth > deepest.depth || (overlap.depth == deepest.depth && overlap.depth > 0 && is_earlier))
      deepest = overlap;
  };
  constexpr std::size_t kFew = 1024;
  if (of_a.size() * of_b.size() > kFew) {
    const BoxTree tree(of_b, execution);
    for (std::uint32_t x = 0; x < of_a.size(); ++x)
      tree.each_overlapping(of_a[x], [&](std::uint32_t y) { compare(x, y); });
    return deepest;
  }
  for (std::uint32_t x = 0; x < of_a.size(); ++x) {
    execution.poll();
    for (std::uint32_t y = 0; y < of_b.size(); ++y)
      if (of_a[x].intersects(of_b[y])) compare(x, y);
  }
  return deepest;
}

std::vector<Overlap> find_overlaps(const Bodies& bodies, const CellsOfBodies& cells,
                                   const Execution& execution) {
  std::vector<Overlap> found;
  if (cells.disjoint && cells.may_share)
    measure_pairs(bodies, sharing_a_cell(bodies, execution), found, execution);
  // Bodies in one group are disjoint, if cells are.
  const std::size_t frames = std::max<std::size_t>(cells.map.frames().size(), 1);
  std::vector<std::vector<std::uint32_t>> groups(cells.disjoint ? frames : 1);
  Pacer pacer(execution);
  for (std::uint32_t k = 0; k < bodies.size(); ++k) {
    const Fragment& f = *bodies.fragments[k];
    pacer.step(1 + f.part_cells.size());
    const std::size_t frame = !cells.disjoint          ? 0
                              : may_leave_its_cells(f) ? kNoIndex
                                                       : only_frame_of(cells.map, f);
    if (frame != kNoIndex)
      groups[frame].push_back(k);
    else
      groups.push_back({k});
  }
  if (!cells.disjoint || groups.size() > 1) measure_all(bodies, groups, found, execution);
  keep_deepest(found, execution);
  return found;
}

}  // namespace fracture
