#include "common/solid/sheet_offsets.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace fracture::solid_detail {
namespace {

/// Cosine of the angle (0.08 degrees) between normals above which they count as one direction.
constexpr double kSameNormal = 1 - 1e-6;
/// Most triangles at a vertex with which a further one is compared. Vertices with more are tips of fans, whose normals differ.
constexpr std::size_t kCompared = 16;

}  // namespace

std::vector<SheetOffset> sheet_offsets(const Surface& surface, const std::vector<TriangleId>& front,
                                       const std::vector<VertexId>& vertices, bool mitred, Pacer& pacer) {
  const auto at = [&](VertexId v) { return to_double(surface.positions[v]); };
  const auto index = [&](VertexId v) { return index_of(v, vertices); };
  std::vector<std::size_t> first(vertices.size() + 1, 0);
  std::vector<Vec3d> unit(front.size());
  std::vector<double> weight(front.size(), 1);
  for (std::size_t i = 0; i < front.size(); ++i) {
    pacer.step(8);
    const Triangle& c = surface.triangles[front[i]];
    const Vec3d n = cross(at(c[1]) - at(c[0]), at(c[2]) - at(c[0]));
    if (const double size = length(n); size > 0) unit[i] = (1 / size) * n;
    if (!mitred) weight[i] = length(n);
    for (const VertexId v : c) ++first[index(v) + 1];
  }
  for (std::size_t k = 0; k < vertices.size(); ++k) first[k + 1] += first[k];
  std::vector<std::size_t> of_vertex(first.back()), next(first.begin(), first.end() - 1);
  for (std::size_t i = 0; i < front.size(); ++i) {
    pacer.step(4);
    for (const VertexId v : surface.triangles[front[i]]) of_vertex[next[index(v)]++] = i;
  }
  std::vector<SheetOffset> offsets(vertices.size());
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    pacer.step(8);
    const std::span<const std::size_t> fan(of_vertex.data() + first[k], first[k + 1] - first[k]);
    Vec3d sum;
    for (std::size_t i = 0; i < fan.size(); ++i) {
      const auto compared = fan.first(mitred ? std::min(i, kCompared) : 0);
      const bool is_known = std::any_of(compared.begin(), compared.end(), [&](std::size_t j) {
        return dot(unit[fan[i]], unit[j]) > kSameNormal;
      });
      if (!is_known) sum = sum + weight[fan[i]] * unit[fan[i]];
    }
    const double l = length(sum);
    if (!(l > 0)) continue;
    offsets[k].normal = (1 / l) * sum;
    if (!mitred) continue;
    for (const std::size_t i : fan)
      if (dot(unit[i], unit[i]) > 0)
        offsets[k].least = std::fmin(offsets[k].least, std::fmax(dot(offsets[k].normal, unit[i]), 0));
  }
  return offsets;
}

}  // namespace fracture::solid_detail
