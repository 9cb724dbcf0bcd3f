#include "common/solid/weld.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/base/words.hpp"
#include "common/solid/faults.hpp"
#include "common/solid/near_points.hpp"
#include "common/solid/polled.hpp"
#include "common/solid/same_positions.hpp"

namespace fracture::solid_detail {
namespace {

/// Also false for NaN.
bool in_range(const Vec3d& p) {
  constexpr double kMost = static_cast<float>(kMaxCoordinate);
  return std::fabs(p.x) <= kMost && std::fabs(p.y) <= kMost && std::fabs(p.z) <= kMost;
}

/// `offset`: SourceFrame::offset of the mesh, m. The range also holds for the position in the file, which is `offset` + p.
bool in_range(const Vec3f& p, const Vec3d& offset) {
  return in_range(to_double(p)) && in_range(offset + to_double(p));
}

/// The place of a vertex that is out of range. If only the offset is too large, the place below the offset would say nothing.
std::string far_place(const Vec3f& p, const Vec3d& offset) {
  if (!in_range(to_double(p))) return "at " + place(p) + ", in metres";
  const Vec3d at = offset + to_double(p);
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (std::fabs(at[k]) > std::fabs(at[axis])) axis = k;
  return short_number(std::fabs(at[axis])) + " m from the file's origin along " +
         std::string(1, "xyz"[axis]) + " (with y up)";
}

tl::unexpected<Error> refuse_vertex(std::uint32_t vertex, const Vec3f& p, const Vec3d& offset) {
  const std::string name = "Vertex " + std::to_string(vertex);
  if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
    return fail(ErrorCode::kNotFinite, name + " has a coordinate that is NaN or infinite.", {},
                {{"vertex", vertex}});
  return fail(ErrorCode::kNotFinite,
              name + " is " + far_place(p, offset) +
                  "; coordinates may be at most 1e11 m from 0. Set 'unit' to the unit of the "
                  "file, or move the mesh to the origin.",
              {}, {{"vertex", vertex}});
}

/// The state of a wedge during numbering. Initially, the lowest wedge at its position. When a triangle uses a
/// wedge at that position: kNumbered, with the id of their vertex. When the wedge itself is used: kUsed as
/// well.
constexpr std::uint32_t kUsed = 1u << 31, kNumbered = 1u << 30, kNumber = kNumbered - 1;

/// Number of triangles between two polls, by which the arrays also grow. The new memory is written while it
/// is still in the cache from zeroing.
constexpr std::size_t kTrianglesAtOnce = 16384;

std::size_t drop_degenerate(Surface& surface, const Execution& execution) {
  std::vector<std::uint8_t> doomed = filled<std::uint8_t>(execution, surface.triangles.size(), 0);
  std::size_t count = 0;
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    const auto& [a, b, c] = surface.triangles[t];
    if (a == b || b == c || c == a) doomed[t] = 1, ++count;
  });
  if (count > 0) surface.remove(doomed, execution);
  return count;
}

/// Converts the triangles of wedges to triangles of vertices. `of_wedge`: the result of first_of_same().
Expected<void> number_vertices(const Mesh& mesh, std::uint32_t* of_wedge, Surface& surface,
                               SolidReport& report, const Execution& execution) {
  surface.triangles.reserve(mesh.triangles.size());
  surface.source.reserve(mesh.triangles.size());
  surface.positions.reserve(std::min(mesh.positions.size(), 3 * mesh.triangles.size()));
  std::uint64_t used_wedges = 0;
  const auto use = [&](std::uint32_t wedge) {
    std::uint32_t& mine = of_wedge[wedge];
    if ((mine & kNumbered) == 0) {
      std::uint32_t& first = of_wedge[mine];
      if ((first & kNumbered) == 0) {
        first = kNumbered | static_cast<std::uint32_t>(surface.positions.size());
        surface.positions.push_back(with_one_zero(mesh.positions[wedge]));
      }
      mine = first;
    }
    mine |= kUsed;
    ++used_wedges;
  };

  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (t % kTrianglesAtOnce == 0) {
      execution.poll();
      surface.triangles.resize(std::min(kept + kTrianglesAtOnce, mesh.triangles.size()));
      surface.source.resize(surface.triangles.size());
    }
    Triangle triangle;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t wedge = mesh.triangles[t][k];
      if (wedge >= mesh.positions.size())
        return fail(ErrorCode::kMalformedMesh, "Triangle " + std::to_string(t) + " refers to vertex " +
                                                   std::to_string(wedge) + "; the mesh has only " +
                                                   std::to_string(mesh.positions.size()) + " vertices.");
      if ((of_wedge[wedge] & kUsed) == 0) {
        if (!in_range(mesh.positions[wedge], mesh.frame.offset))
          return refuse_vertex(wedge, mesh.positions[wedge], mesh.frame.offset);
        use(wedge);
      }
      triangle[k] = VertexId{of_wedge[wedge] & kNumber};
    }
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) {
      if (report.degenerate_dropped++ == 0)
        report.add_sample("degenerate_dropped", surface.positions[triangle[0]]);
      continue;
    }
    surface.triangles[kept] = triangle;
    surface.source[kept++] = static_cast<std::uint32_t>(t);
  }
  surface.triangles.resize(kept);
  surface.source.resize(kept);
  report.welded = used_wedges - surface.positions.size();
  if (surface.triangles.empty())
    return fail(ErrorCode::kEmptyMesh, "All " + std::to_string(mesh.triangles.size()) +
                                           " triangles have two vertices at the same position.");
  return {};
}

}  // namespace

Expected<Surface> weld_exact(const Mesh& mesh, SolidReport& report, const Execution& execution) {
  report.source_triangles = mesh.triangles.size();
  report.source_vertices = mesh.positions.size();
  if (mesh.triangles.empty()) return fail(ErrorCode::kEmptyMesh, "The mesh has no triangles.");

  if (mesh.positions.size() > kNumber)
    return fail(ErrorCode::kTooLarge, "The mesh has " + grouped(mesh.positions.size()) +
                                          " vertices; the limit for a solid is " + grouped(kNumber) +
                                          ". Reduce the mesh, or divide it into several files.");
  const std::unique_ptr<std::uint32_t[]> of_wedge = first_of_same(mesh.positions, execution);
  Surface surface;
  Expected<void> numbered;
  // Vertices are numbered sequentially; meanwhile, another thread allocates memory for the twins.
  side_by_side(
      execution, mesh.triangles.size(),
      [&] { numbered = number_vertices(mesh, of_wedge.get(), surface, report, execution); },
      [&] { surface.twin.of_triangle = filled(execution, mesh.triangles.size(), kThreeOpen); });
  if (!numbered) return tl::unexpected(std::move(numbered.error()));
  surface.twin.of_triangle.resize(surface.triangles.size());
  return surface;
}

namespace {

struct OpenEdge {
  VertexId a, b;
  auto operator<=>(const OpenEdge&) const = default;
};

struct OpenEdges {
  std::vector<OpenEdge> edges;
  std::vector<VertexId> ends;  ///< ascending, each once
};

OpenEdges open_edges_of(const EdgeTable& edges, const Execution& execution) {
  OpenEdges open;
  edges.for_each(execution, [&](VertexId a, VertexId b, std::span<const EdgeUse> uses) {
    if (uses.size() != 1) return;
    make_room(execution, open.edges);
    make_room(execution, open.ends, 2);
    open.edges.push_back({a, b});
    open.ends.push_back(a);
    open.ends.push_back(b);
  });
  sort_with_polls(execution, open.ends.begin(), open.ends.end());
  open.ends.erase(std::unique(open.ends.begin(), open.ends.end()), open.ends.end());
  return open;
}

/// The ends of open edges in clusters of near ones. A cluster is useful if it makes two different open edges coincide.
struct Clusters {
  DisjointSets near;
  std::vector<std::uint8_t> useful;  ///< per vertex that is the root of a cluster
  std::uint64_t met = 0;             ///< open edges that coincide with another one

  bool merges(VertexId v) {
    const VertexId root{near.find(v)};
    return root != v && useful[root];
  }
};

Clusters clusters_of(const Surface& surface, const OpenEdges& open, double tolerance,
                     const Execution& execution) {
  Clusters clusters{singletons(execution, surface.positions.size()),
                    filled<std::uint8_t>(execution, surface.positions.size(), 0)};
  unite_near(surface.positions, open.ends, tolerance, clusters.near, execution);
  if (clusters.near.set_count() == surface.positions.size()) return clusters;
  std::vector<OpenEdge> moved;
  moved.reserve(open.edges.size());
  for_each_polled(execution, open.edges.size(), [&](std::size_t i) {
    const VertexId a{clusters.near.find(open.edges[i].a)}, b{clusters.near.find(open.edges[i].b)};
    if (a != b) moved.push_back({std::min(a, b), std::max(a, b)});
  });
  sort_with_polls(execution, moved.begin(), moved.end());
  for_each_polled(execution, moved.size(), [&](std::size_t i) {
    const bool after = i > 0 && moved[i] == moved[i - 1],
               before = i + 1 < moved.size() && moved[i] == moved[i + 1];
    if (after) clusters.useful[moved[i].a] = clusters.useful[moved[i].b] = 1;
    clusters.met += after || before;
  });
  return clusters;
}

}  // namespace

bool weld_tolerant(Surface& surface, const EdgeTable& edges, double tolerance, SolidReport& report,
                   const Execution& execution) {
  if (!(tolerance > 0)) return false;
  const OpenEdges open = open_edges_of(edges, execution);
  Clusters clusters = clusters_of(surface, open, tolerance, execution);
  DisjointSets& near = clusters.near;
  const std::vector<std::uint8_t>& useful = clusters.useful;
  std::uint64_t merged = 0;
  std::vector<VertexId> target = filled(execution, surface.positions.size(), kNoVertex);
  for_each_polled(execution, open.ends.size(), [&](std::size_t i) {
    const VertexId v = open.ends[i], root{near.find(v)};
    if (root == v || !useful[root]) return;
    target[v] = root;
    if (merged++ == 0) report.add_sample("welded_tolerant", surface.positions[v]);
  });
  if (merged == 0) return false;
  for_each_polled(execution, surface.triangles.size(), [&](std::size_t t) {
    for (VertexId& v : surface.triangles[t])
      if (target[v] != kNoVertex) v = target[v];
  });
  report.welded_tolerant += merged;
  report.degenerate_dropped += drop_degenerate(surface, execution);
  return true;
}

void offer_welding(const Surface& surface, const EdgeTable& edges, double diagonal, double tolerance,
                   SolidReport& report, const Execution& execution) {
  static constexpr double kTolerances[] = {1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5,
                                           5e-6, 2e-6, 1e-6, 5e-7, 2e-7, 1e-7};
  static_assert(kTolerances[0] == kWidestCrack);
  const OpenEdges open = open_edges_of(edges, execution);
  // A tolerance beyond the length of the edges merges whole loops and joins nothing, so the largest is not always the best.
  double best = 0;
  Clusters found;
  for (const double wider : kTolerances) {
    if (wider <= tolerance) break;
    Clusters clusters = clusters_of(surface, open, wider * diagonal, execution);
    if (clusters.near.set_count() == surface.positions.size())
      break;  // nothing is near, so nothing is nearer
    if (clusters.met == 0 || clusters.met < found.met) continue;
    best = wider;
    found = std::move(clusters);
  }
  if (best == 0) return;
  const auto first =
      std::find_if(open.ends.begin(), open.ends.end(), [&](VertexId v) { return found.merges(v); });
  report.choices.push_back({.kind = "crack",
                            .parameters = {{"weld_tolerance", best}},
                            .text = counted(found.met, "open edge is", "open edges are") + " within " +
                                    short_number(best * diagonal) + " m of another open edge, the first at " +
                                    place(surface.positions[*first]) +
                                    ". Each side of such a crack was closed separately. weld_tolerance=" +
                                    short_number(best) + " joins the two sides."});
}

}  // namespace fracture::solid_detail
