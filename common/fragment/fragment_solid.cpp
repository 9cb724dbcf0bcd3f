#include "common/fragment/fragment_solid.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"
#include "common/exact/volume_sum.hpp"
#include "common/solid/layers.hpp"

namespace fracture {
namespace {

class Builder {
 public:
  Builder(const Fragment& fragment, std::span<const Vec3f> world, const Solid& whole,
          const Execution& execution)
      : f_(fragment), world_(world), whole_(whole), execution_(execution), pacer_(execution) {}

  FragmentSolid run() {
    order_by_part();
    pair_edges();
    split_fans();
    number_shells();
    describe_parts();
    copy_source();
    return std::move(out_);
  }

 private:
  std::size_t triangle_count() const { return order_.size(); }
  /// The index in the fragment of corner k of triangle t.
  std::uint32_t corner(std::size_t t, std::size_t k) const { return f_.indices[3 * order_[t] + k]; }

  /// Sorts the triangles by their parts, and keeps their order in a part.
  void order_by_part() {
    const std::size_t count = f_.indices.size() / 3;
    order_.resize(count);
    std::iota(order_.begin(), order_.end(), 0u);
    const std::vector<std::uint32_t>& parts = f_.triangle_parts;
    if (parts.empty()) {
      out_.parts = {f_.part};
    } else {
      out_.parts = parts;
      sort_with_polls(execution_, out_.parts.begin(), out_.parts.end());
      out_.parts.erase(std::unique(out_.parts.begin(), out_.parts.end()), out_.parts.end());
      sort_with_polls(execution_, order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tie(parts[a], a) < std::tie(parts[b], b);
      });
    }
    Solid& s = out_.solid;
    s.part.reserve(count);
    for (const std::uint32_t t : order_) {
      pacer_.step(2);
      const std::uint32_t part = parts.empty() ? f_.part : parts[t];
      s.part.push_back(static_cast<std::uint32_t>(
          std::lower_bound(out_.parts.begin(), out_.parts.end(), part) - out_.parts.begin()));
    }
  }

  /// Gives each two triangles that use an edge of the topology in opposite directions one edge.
  void pair_edges() {
    struct Half {
      std::uint32_t lo, hi, half;  // half: 3 * triangle + corner
    };
    std::vector<Half> halves;
    halves.reserve(3 * triangle_count());
    for (std::size_t t = 0; t < triangle_count(); ++t)
      for (std::uint32_t k = 0; k < 3; ++k) {
        pacer_.step();
        const std::uint32_t a = f_.topology[corner(t, k)], b = f_.topology[corner(t, (k + 1) % 3)];
        halves.push_back({std::min(a, b), std::max(a, b), static_cast<std::uint32_t>(3 * t + k)});
      }
    sort_with_polls(execution_, halves.begin(), halves.end(), [](const Half& x, const Half& y) {
      return std::tie(x.lo, x.hi, x.half) < std::tie(y.lo, y.hi, y.half);
    });
    twin_.assign(halves.size(), 0);
    for (std::size_t k = 0; k < halves.size(); k += 2) {
      pacer_.step();
      if (k + 1 == halves.size() || halves[k].lo != halves[k + 1].lo || halves[k].hi != halves[k + 1].hi ||
          from_lo(halves[k].half) == from_lo(halves[k + 1].half))
        throw InternalError("fragment " + std::to_string(f_.id) + " is open at its vertex " +
                            std::to_string(halves[k].lo));
      twin_[halves[k].half] = halves[k + 1].half;
      twin_[halves[k + 1].half] = halves[k].half;
    }
  }
  bool from_lo(std::uint32_t half) const {
    const std::size_t t = half / 3, k = half % 3;
    return f_.topology[corner(t, k)] < f_.topology[corner(t, (k + 1) % 3)];
  }

  /// Numbers the vertices: one for each fan of triangles. Then numbers the edges, in the order of their triangles.
  void split_fans() {
    Solid& s = out_.solid;
    const std::size_t halves = twin_.size();
    DisjointSets fans(halves);  // of corners
    const auto next = [](std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; };
    for (std::uint32_t h = 0; h < halves; ++h) {
      pacer_.step();
      fans.unite(h, next(twin_[h]));
    }
    std::vector<std::uint32_t> number(halves, kNoIndex);
    s.triangles.resize(triangle_count());
    s.wedges.resize(triangle_count());
    for (std::uint32_t h = 0; h < halves; ++h) {
      pacer_.step();
      const std::uint32_t root = fans.find(h), wedge = corner(h / 3, h % 3);
      if (number[root] == kNoIndex) {
        number[root] = static_cast<std::uint32_t>(s.positions.size());
        s.positions.push_back(world_[wedge]);
      }
      s.triangles[h / 3][h % 3] = VertexId{number[root]};
      s.wedges[h / 3][h % 3] = wedge;
    }
    s.edges.resize(triangle_count());
    for (std::uint32_t h = 0; h < halves; ++h) {
      pacer_.step();
      if (twin_[h] < h) {
        s.edges[h / 3][h % 3] = s.edges[twin_[h] / 3][twin_[h] % 3];
        continue;
      }
      const VertexId a = s.triangles[h / 3][h % 3], b = s.triangles[h / 3][next(h) % 3];
      s.edges[h / 3][h % 3] = static_cast<std::uint32_t>(s.edge_vertices.size());
      s.edge_vertices.push_back({std::min(a, b), std::max(a, b)});
    }
  }

  void number_shells() {
    Solid& s = out_.solid;
    DisjointSets sets(triangle_count());
    for (std::uint32_t h = 0; h < twin_.size(); ++h) {
      pacer_.step();
      sets.unite(h / 3, twin_[h] / 3);
    }
    std::vector<std::uint32_t> number(triangle_count(), kNoIndex);
    for (std::uint32_t t = 0; t < triangle_count(); ++t) {
      pacer_.step();
      std::uint32_t& shell = number[sets.find(t)];
      if (shell == kNoIndex) {
        shell = static_cast<std::uint32_t>(first_of_shell_.size());
        first_of_shell_.push_back(t);
      }
      s.shell.push_back(shell);
    }
  }

  void describe_parts() {
    Solid& s = out_.solid;
    double largest = 0;
    for (const Part& part : whole_.parts) largest = std::fmax(largest, part.volume);
    for (const std::uint32_t p : out_.parts) {
      const Part& part = whole_.parts[p];
      s.parts.push_back({{}, largest, {}, 0, f_.triangle_parts.empty() ? f_.node : part.node, part.color});
      s.parts.back().nodes = f_.triangle_parts.empty() ? f_.nodes : part.nodes;
    }
    std::vector<exact::VolumeSum> sums;
    for (const std::uint32_t t : first_of_shell_)
      sums.emplace_back(to_double(s.positions[s.triangles[t][0]]));
    for (std::size_t t = 0; t < triangle_count(); ++t) {
      pacer_.step(8);
      const auto& v = s.triangles[t];
      const Vec3d a = to_double(s.positions[v[0]]), b = to_double(s.positions[v[1]]),
                  c = to_double(s.positions[v[2]]);
      sums[s.shell[t]].add(a, b, c);
      s.report.area += 0.5 * length(cross(b - a, c - a));
      for (const Vec3d& p : {a, b, c}) s.parts[s.part[t]].box.add(p);
    }
    // The largest shell of a part comes first.
    std::vector<double> first(s.parts.size(), -HUGE_VAL);
    for (std::uint32_t shell = 0; shell < sums.size(); ++shell) {
      const double volume = sums[shell].volume();
      s.report.volume += volume;
      s.report.absolute_volume += std::fabs(volume);
      const std::uint32_t p = s.part[first_of_shell_[shell]];
      std::vector<std::uint32_t>& shells = s.parts[p].shells;
      shells.push_back(shell);
      if (volume <= first[p]) continue;
      first[p] = volume;
      std::swap(shells.front(), shells.back());
    }
    s.box = whole_.box;
    s.layers = solid_detail::assign_layers(s.parts, execution_);
  }

  void copy_source() {
    Solid& s = out_.solid;
    std::vector<std::uint32_t> material(triangle_count());
    std::vector<char> mirrored(triangle_count(), 0);
    for (const FragmentPrimitive& p : f_.primitives)
      std::fill_n(material.begin() + p.first_index / 3, p.index_count / 3, p.material);
    for (const IndexRange& cap : f_.caps) std::fill_n(mirrored.begin() + cap.first / 3, cap.count / 3, 1);
    for (const std::uint32_t t : order_) {
      pacer_.step();
      s.material.push_back(material[t]);
      s.mirrored.push_back(mirrored[t]);
    }
    auto mesh = std::make_shared<Mesh>();
    mesh->positions.assign(world_.begin(), world_.end());
    mesh->frame = whole_.source->frame;
    execution_.poll();
    mesh->attributes = f_.attributes;
    execution_.poll();
    s.source = std::move(mesh);
  }

  const Fragment& f_;
  const std::span<const Vec3f> world_;
  const Solid& whole_;
  const Execution& execution_;
  Pacer pacer_;
  FragmentSolid out_;
  std::vector<std::uint32_t> order_;  // per triangle: its number in the fragment
  std::vector<std::uint32_t> twin_;   // per half edge, 3 * triangle + corner
  std::vector<std::uint32_t> first_of_shell_;
};

}  // namespace

FragmentSolid solid_of_fragment(const Fragment& fragment, std::span<const Vec3f> world, const Solid& whole,
                                const Execution& execution) {
  return Builder(fragment, world, whole, execution).run();
}

}  // namespace fracture
