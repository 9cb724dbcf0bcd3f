#include "common/fragment/repeated_edges.hpp"

#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {
namespace {

/// Half-edge h = 3 t + k runs from corner k of triangle t to the next one.
using HalfEdge = std::uint32_t;
HalfEdge next(HalfEdge h) { return h % 3 == 2 ? h - 2 : h + 1; }
HalfEdge previous(HalfEdge h) { return h % 3 == 0 ? h + 2 : h - 1; }

class Splitter {
 public:
  Splitter(Fragment& fragment, const Execution& execution)
      : f_(fragment), execution_(execution), pacer_(execution) {}

  bool run() {
    const bool dropped = drop_degenerate();
    if (!pair_all() || repeated_.empty()) return dropped;
    label_fans();
    for (const Edge& edge : repeated_) part(edge);
    rename();
    return true;
  }

 private:
  /// A range of uses_: all uses of one edge, sorted by direction.
  struct Edge {
    std::size_t first, last;
  };
  struct Use {
    std::uint32_t low, high;
    bool backward;
    HalfEdge h;
    auto operator<=>(const Use&) const = default;
  };

  std::uint32_t from(HalfEdge h) const { return f_.topology[f_.indices[h]]; }

  /// Drops triangles with two corners at one vertex: two of their edges are each other's opposites, and the
  /// third has no length. Returns whether there were any.
  bool drop_degenerate() {
    const std::size_t count = f_.indices.size() / 3;
    std::vector<std::uint32_t> kept_before{0};  // per triangle: number of triangles before it that are kept
    kept_before.reserve(count + 1);
    for (std::size_t t = 0; t < count; ++t) {
      pacer_.step();
      const auto h = static_cast<HalfEdge>(3 * t);
      const bool degenerate = from(h) == from(h + 1) || from(h + 1) == from(h + 2) || from(h + 2) == from(h);
      const std::uint32_t before = kept_before.back();
      kept_before.push_back(before + !degenerate);
      if (before == t || degenerate) continue;
      std::copy_n(f_.indices.begin() + h, 3, f_.indices.begin() + 3 * std::ptrdiff_t{before});
    }
    if (kept_before.back() == count) return false;
    f_.indices.resize(3 * std::size_t{kept_before.back()});
    const auto move = [&](std::uint32_t& first, std::uint32_t& length) {
      const std::uint32_t end = 3 * kept_before[(first + length) / 3];
      first = 3 * kept_before[first / 3];
      length = end - first;
    };
    for (std::size_t t = 0; t < f_.triangle_parts.size(); ++t)
      if (kept_before[t + 1] > kept_before[t]) f_.triangle_parts[kept_before[t]] = f_.triangle_parts[t];
    if (!f_.triangle_parts.empty()) f_.triangle_parts.resize(kept_before.back());
    for (FragmentPrimitive& p : f_.primitives) move(p.first_index, p.index_count);
    std::erase_if(f_.primitives, [](const FragmentPrimitive& p) { return p.index_count == 0; });
    for (std::vector<IndexRange>* ranges : {&f_.caps, &f_.earlier_caps}) {
      for (IndexRange& range : *ranges) move(range.first, range.count);
      std::erase_if(*ranges, [](const IndexRange& range) { return range.count == 0; });
    }
    return true;
  }

  /// Gives each half-edge an opposite, and lists the edges that have several pairs. Returns false if a
  /// half-edge has no opposite.
  bool pair_all() {
    const auto count = static_cast<HalfEdge>(f_.indices.size());
    uses_.reserve(count);
    for (HalfEdge h = 0; h < count; ++h) {
      pacer_.step();
      const std::uint32_t a = from(h), b = from(next(h));
      uses_.push_back({std::min(a, b), std::max(a, b), b < a, h});
    }
    sort_with_polls(execution_, uses_.begin(), uses_.end());
    twin_.assign(count, kNoIndex);
    touched_.assign(f_.positions.size(), 0);
    for (std::size_t first = 0, last = 0; first < uses_.size(); first = last) {
      const std::uint32_t low = uses_[first].low, high = uses_[first].high;
      std::size_t there = 0;
      for (last = first; last < uses_.size() && uses_[last].low == low && uses_[last].high == high; ++last) {
        pacer_.step();
        there += !uses_[last].backward;
      }
      const std::size_t pairs = (last - first) / 2;
      if (low == high || 2 * there != last - first) return false;
      for (std::size_t k = first; k < first + pairs; ++k) glue(uses_[k].h, uses_[k + pairs].h);
      if (pairs == 1) continue;
      repeated_.push_back({first, last});
      touched_[low] = touched_[high] = 1;
    }
    return true;
  }

  void glue(HalfEdge h, HalfEdge g) {
    twin_[h] = g;
    twin_[g] = h;
  }

  /// The next half-edge in the fan around the vertex at which h starts.
  HalfEdge turn(HalfEdge h) const { return twin_[previous(h)]; }

  /// Numbers the fans around the ends of repeated edges. Each half-edge that starts there gets its fan's
  /// number.
  void label_fans() {
    fan_.assign(f_.indices.size(), kNoIndex);
    for (HalfEdge start = 0; start < fan_.size(); ++start) {
      if (fan_[start] != kNoIndex || !touched_[from(start)]) continue;
      for (HalfEdge h = start; fan_[h] == kNoIndex; h = turn(h)) {
        pacer_.step();
        fan_[h] = fans_;
      }
      ++fans_;
    }
  }

  /// Exchanges opposites until no two pairs of the edge are in the same fan at both of its ends. This ends,
  /// because each exchange makes two more fans, and fans never unite.
  void part(const Edge& edge) {
    const auto pairs = static_cast<std::ptrdiff_t>((edge.last - edge.first) / 2);
    const auto begin = uses_.begin() + static_cast<std::ptrdiff_t>(edge.first), end = begin + pairs;
    const auto fans = [&](const Use& use) { return std::pair(fan_[use.h], fan_[next(use.h)]); };
    for (bool exchanged = true; exchanged;) {
      exchanged = false;
      sort_with_polls(execution_, begin, end, [&](const Use& x, const Use& y) {
        return std::tuple(fans(x), x.h) < std::tuple(fans(y), y.h);
      });
      for (auto use = begin; use + 1 < end; ++use) {
        pacer_.step();
        if (fans(use[0]) != fans(use[1])) continue;
        const HalfEdge h = use[0].h, g = use[1].h, to_h = twin_[h], to_g = twin_[g];
        glue(h, to_g);
        glue(g, to_h);
        renumber_smaller(h, g);
        renumber_smaller(next(h), next(g));
        exchanged = true;
      }
    }
  }

  /// Renumbers the smaller of the two fans that one fan was split into. h and g start at the fan's vertex,
  /// one in each of the two.
  void renumber_smaller(HalfEdge h, HalfEdge g) {
    HalfEdge x = turn(h), y = turn(g);
    for (; x != h && y != g; x = turn(x), y = turn(y)) pacer_.step();
    const HalfEdge start = x == h ? h : g;
    HalfEdge at = start;
    do {
      pacer_.step();
      fan_[at] = fans_;
      at = turn(at);
    } while (at != start);
    ++fans_;
  }

  /// Gives each fan its own vertices: the first fan at a vertex keeps it, and the others get a copy.
  void rename() {
    std::vector<std::uint32_t> first_of_fan(fans_, kNoIndex);  // the first vertex of each fan
    std::vector<std::array<std::uint32_t, 3>> corners;         // vertex, fan, position in the indices
    for (HalfEdge h = 0; h < fan_.size(); ++h) {
      pacer_.step();
      if (fan_[h] != kNoIndex) corners.push_back({f_.indices[h], fan_[h], h});
    }
    sort_with_polls(execution_, corners.begin(), corners.end());
    for (std::size_t k = 0; k < corners.size(); ++k) {
      pacer_.step();
      const auto [vertex, fan, h] = corners[k];
      const bool is_first_corner = k == 0 || corners[k - 1][0] != vertex;
      const bool is_of_same_copy = !is_first_corner && corners[k - 1][1] == fan;
      if (is_of_same_copy)
        f_.indices[h] = f_.indices[corners[k - 1][2]];
      else if (!is_first_corner)
        f_.indices[h] = copy(vertex);
      first_of_fan[fan] = std::min(first_of_fan[fan], f_.indices[h]);
    }
    for (const auto& [vertex, fan, h] : corners) f_.topology[f_.indices[h]] = first_of_fan[fan];
  }

  std::uint32_t copy(std::uint32_t vertex) {
    const auto again = [&](auto& values) {
      if (values.empty()) return;
      const auto value = values[vertex];
      values.push_back(value);
    };
    again(f_.positions);
    again(f_.topology);
    again(f_.attributes.normals);
    again(f_.attributes.tangents);
    for (auto& set : f_.attributes.uvs) again(set);
    for (auto& set : f_.attributes.colors) again(set);
    return static_cast<std::uint32_t>(f_.positions.size() - 1);
  }

  Fragment& f_;
  const Execution& execution_;
  Pacer pacer_;
  std::vector<Use> uses_;
  std::vector<Edge> repeated_;
  std::vector<HalfEdge> twin_;
  std::vector<std::uint8_t> touched_;  // per vertex of the topology
  std::vector<std::uint32_t> fan_;     // per half-edge: the fan at its start
  std::uint32_t fans_ = 0;
};

}  // namespace

bool split_repeated_edges(Fragment& fragment, const Execution& execution) {
  return Splitter(fragment, execution).run();
}

}  // namespace fracture
