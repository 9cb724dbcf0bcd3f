#include "common/solid/weld.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace fracture::solid_detail {
namespace {

std::uint64_t hash_position(const Vec3f& p) {
  const std::uint64_t x = std::bit_cast<std::uint32_t>(p.x), y = std::bit_cast<std::uint32_t>(p.y),
                      z = std::bit_cast<std::uint32_t>(p.z);
  std::uint64_t h = (x | y << 32) * 0x9e3779b97f4a7c15ull;
  h = (h ^ (h >> 29) ^ z) * 0xbf58476d1ce4e5b9ull;
  return h ^ (h >> 32);
}

bool finite(const Vec3f& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

std::size_t drop_degenerate(Surface& surface) {
  std::vector<std::uint8_t> doomed(surface.triangles.size(), 0);
  std::size_t count = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    if (a == b || b == c || c == a) doomed[t] = 1, ++count;
  }
  if (count > 0) surface.remove(doomed);
  return count;
}

/// Unites all pairs of `members` nearer than the tolerance, by a hash-free grid: cells sorted by coordinate.
void unite_near(const std::vector<Vec3f>& positions, const std::vector<VertexId>& members, double tolerance,
                DisjointSets& sets) {
  struct Entry {
    std::array<std::int64_t, 3> cell;
    VertexId vertex;
    auto operator<=>(const Entry&) const = default;
  };
  const double inverse = 1 / tolerance;
  const auto cell_of = [inverse](float c) { return static_cast<std::int64_t>(std::floor(c * inverse)); };
  std::vector<Entry> entries;
  entries.reserve(members.size());
  for (const VertexId v : members) {
    const Vec3f& p = positions[v];
    entries.push_back({{cell_of(p.x), cell_of(p.y), cell_of(p.z)}, v});
  }
  std::sort(entries.begin(), entries.end());
  for (const Entry& e : entries)
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy) {
        const Entry low{{e.cell[0] + dx, e.cell[1] + dy, e.cell[2] - 1}, 0};
        for (auto i = std::lower_bound(entries.begin(), entries.end(), low);
             i != entries.end() && i->cell[0] == low.cell[0] && i->cell[1] == low.cell[1] &&
             i->cell[2] <= e.cell[2] + 1;
             ++i) {
          if (i->vertex >= e.vertex) continue;
          if (length(to_double(positions[i->vertex]) - to_double(positions[e.vertex])) <= tolerance)
            sets.unite(i->vertex, e.vertex);
        }
      }
}

}  // namespace

Expected<Surface> weld_exact(const Mesh& mesh, SolidReport& report, const Execution& execution) {
  report.source_triangles = mesh.triangles.size();
  report.source_vertices = mesh.positions.size();
  if (mesh.triangles.empty()) return fail(ErrorCode::kEmptyMesh, "The mesh has no triangles.");

  Surface surface;
  const std::size_t wedge_bound = std::min(mesh.positions.size(), 3 * mesh.triangles.size());
  surface.triangles.resize(mesh.triangles.size());
  surface.source.resize(mesh.triangles.size());
  surface.positions.reserve(wedge_bound);
  std::vector<VertexId> vertex_of_wedge(mesh.positions.size(), kNoIndex);
  const std::size_t table_size = std::bit_ceil(2 * wedge_bound + 1);
  std::vector<VertexId> table(table_size, kNoIndex);
  std::uint64_t used_wedges = 0;
  std::size_t kept = 0;

  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (t % 65536 == 0) execution.poll();
    Triangle triangle;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t wedge = mesh.triangles[t][k];
      if (wedge >= mesh.positions.size())
        return fail(ErrorCode::kMalformedMesh, "Triangle " + std::to_string(t) + " uses vertex " +
                                                   std::to_string(wedge) + " of " +
                                                   std::to_string(mesh.positions.size()) + ".");
      VertexId& vertex = vertex_of_wedge[wedge];
      if (vertex == kNoIndex) {
        const Vec3f& raw = mesh.positions[wedge];
        const Vec3f p{raw.x + 0.0f, raw.y + 0.0f, raw.z + 0.0f};  // -0 + 0 is +0
        if (!finite(p))
          return fail(ErrorCode::kNotFinite,
                      "Vertex " + std::to_string(wedge) + " has a coordinate that is NaN or infinite.", {},
                      {{"vertex", wedge}});
        ++used_wedges;
        std::size_t slot = hash_position(p) & (table_size - 1);
        while (table[slot] != kNoIndex && !(surface.positions[table[slot]] == p))
          slot = (slot + 1) & (table_size - 1);
        if (table[slot] == kNoIndex) {
          table[slot] = static_cast<VertexId>(surface.positions.size());
          surface.positions.push_back(p);
        }
        vertex = table[slot];
      }
      triangle[k] = vertex;
    }
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) {
      if (report.degenerate_dropped++ == 0)
        report.add_sample("degenerate_dropped", surface.positions[triangle[0]]);
      continue;
    }
    surface.triangles[kept] = triangle;
    surface.source[kept++] = static_cast<TriangleId>(t);
  }
  surface.triangles.resize(kept);
  surface.source.resize(kept);
  report.welded = used_wedges - surface.positions.size();
  if (surface.triangles.empty())
    return fail(ErrorCode::kEmptyMesh, "All " + std::to_string(mesh.triangles.size()) +
                                           " triangles are degenerate: two corners at the same position.");
  return surface;
}

bool weld_tolerant(Surface& surface, const EdgeTable& edges, double tolerance, SolidReport& report) {
  if (!(tolerance > 0)) return false;
  struct OpenEdge {
    VertexId a, b;
  };
  std::vector<OpenEdge> open;
  std::vector<VertexId> members;
  edges.for_each([&](VertexId a, VertexId b, std::span<const EdgeUse> uses) {
    if (uses.size() != 1) return;
    open.push_back({a, b});
    members.push_back(a);
    members.push_back(b);
  });
  std::sort(members.begin(), members.end());
  members.erase(std::unique(members.begin(), members.end()), members.end());
  DisjointSets near(surface.positions.size());
  unite_near(surface.positions, members, tolerance, near);

  // A cluster is useful when it makes two different open edges meet.
  struct Met {
    VertexId a, b;
    auto operator<=>(const Met&) const = default;
  };
  std::vector<Met> met;
  for (const OpenEdge& e : open) {
    const VertexId a = near.find(e.a), b = near.find(e.b);
    if (a != b) met.push_back({std::min(a, b), std::max(a, b)});
  }
  std::sort(met.begin(), met.end());
  std::vector<std::uint8_t> useful(surface.positions.size(), 0);
  for (std::size_t i = 1; i < met.size(); ++i)
    if (met[i] == met[i - 1]) useful[met[i].a] = useful[met[i].b] = 1;
  std::uint64_t merged = 0;
  std::vector<VertexId> target(surface.positions.size());
  for (VertexId v = 0; v < target.size(); ++v) target[v] = v;
  for (const VertexId v : members) {
    const VertexId root = near.find(v);
    if (root == v || !useful[root]) continue;
    target[v] = root;
    if (merged++ == 0) report.add_sample("welded_tolerant", surface.positions[v]);
  }
  if (merged == 0) return false;
  for (Triangle& triangle : surface.triangles)
    for (VertexId& v : triangle) v = target[v];
  report.welded_tolerant += merged;
  report.degenerate_dropped += drop_degenerate(surface);
  return true;
}

}  // namespace fracture::solid_detail
