#include "common/solid/patch.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/ranked_set.hpp"

namespace fracture {
namespace {

/// A subset of the numbers below n: a bit for each number if it is large, otherwise a list.
class Chosen {
 public:
  Chosen(std::size_t n, std::size_t expected) {
    if (n / 64 <= 4 * expected) bits_.emplace(n);
  }
  void add(std::uint32_t k) {
    if (bits_)
      bits_->add(k);
    else
      list_.push_back(k);
  }
  void close(const Execution& execution) {
    if (bits_) return bits_->close();
    sort_with_polls(execution, list_.begin(), list_.end());
    list_.erase(std::unique(list_.begin(), list_.end()), list_.end());
  }
  std::uint32_t size() const { return bits_ ? bits_->size() : static_cast<std::uint32_t>(list_.size()); }
  std::uint32_t rank(std::uint32_t k) const {
    if (bits_) return bits_->rank(k);
    return static_cast<std::uint32_t>(std::lower_bound(list_.begin(), list_.end(), k) - list_.begin());
  }
  template <class Visit>
  void each(const Visit& visit) const {
    if (bits_) return bits_->each(visit);
    for (const std::uint32_t k : list_) visit(k);
  }

 private:
  std::optional<RankedSet> bits_;
  std::vector<std::uint32_t> list_;
};

}  // namespace

std::uint32_t SolidPatch::local_part(std::uint32_t part) const {
  return static_cast<std::uint32_t>(std::lower_bound(parts.begin(), parts.end(), part) - parts.begin());
}

SolidPatch patch_of(const Solid& whole, std::vector<std::uint32_t> triangles,
                    std::span<const std::uint32_t> further_parts, const Execution& execution) {
  Pacer pacer(execution);
  SolidPatch patch;
  const std::size_t expected = triangles.size();
  Chosen vertices(whole.positions.size(), expected), edges(whole.edge_vertices.size(), expected),
      parts(whole.parts.size(), expected), layers(whole.layers, expected);
  for (const std::uint32_t t : triangles) {
    pacer.step(2);
    for (const VertexId v : whole.triangles[t]) vertices.add(v);
    for (const std::uint32_t e : whole.edges[t]) edges.add(e);
    parts.add(whole.part[t]);
  }
  for (const std::uint32_t p : further_parts) parts.add(p);
  for (Chosen* chosen : {&vertices, &edges, &parts}) chosen->close(execution);
  parts.each([&](std::uint32_t p) { layers.add(whole.parts[p].layer); });
  layers.close(execution);

  Solid& s = patch.solid;
  s.source = whole.source;
  s.box = whole.box;
  s.layers = layers.size();
  parts.each([&](std::uint32_t p) {
    const Part& part = whole.parts[p];
    patch.parts.push_back(p);
    s.parts.push_back({{}, part.volume, part.box, layers.rank(part.layer), part.node});
    s.parts.back().nodes = part.nodes;
  });
  patch.vertices.reserve(vertices.size());
  s.positions.reserve(vertices.size());
  vertices.each([&](std::uint32_t v) {
    pacer.step();
    patch.vertices.push_back(VertexId{v});
    s.positions.push_back(whole.positions[v]);
  });
  s.edge_vertices.reserve(edges.size());
  edges.each([&](std::uint32_t e) {
    pacer.step();
    const auto [lo, hi] = whole.edge_vertices[e];
    s.edge_vertices.push_back({VertexId{vertices.rank(lo)}, VertexId{vertices.rank(hi)}});
  });
  const bool has_attributes = !whole.wedges.empty();  // an image has none
  for (auto* of_triangle : {&s.shell, &s.part}) of_triangle->reserve(triangles.size());
  s.triangles.reserve(triangles.size());
  s.edges.reserve(triangles.size());
  if (has_attributes) {
    s.wedges.reserve(triangles.size());
    s.material.reserve(triangles.size());
  }
  for (const std::uint32_t t : triangles) {
    pacer.step(2);
    const auto& v = whole.triangles[t];
    const auto& e = whole.edges[t];
    s.triangles.push_back(
        {VertexId{vertices.rank(v[0])}, VertexId{vertices.rank(v[1])}, VertexId{vertices.rank(v[2])}});
    s.edges.push_back({edges.rank(e[0]), edges.rank(e[1]), edges.rank(e[2])});
    s.shell.push_back(whole.shell[t]);
    s.part.push_back(parts.rank(whole.part[t]));
    if (!has_attributes) continue;
    s.wedges.push_back(whole.wedges[t]);
    s.material.push_back(whole.material[t]);
  }
  patch.triangles = std::move(triangles);
  return patch;
}

}  // namespace fracture
