#include "common/solid/weld.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

#include "common/base/pacer.hpp"
#include "common/solid/near_points.hpp"
#include "common/solid/polled.hpp"

namespace fracture::solid_detail {
namespace {

/// Where positions stand in a hash table: the folded product of two keyed halves. The keys are drawn once for
/// each process, so that nobody can prepare positions that collide. They show in no answer, since vertices
/// are numbered as the triangles use them.
class PositionHash {
 public:
  PositionHash() {
    static const std::array<std::uint64_t, 2> drawn = [] {
      std::random_device device;
      std::array<std::uint64_t, 2> keys;
      for (std::uint64_t& key : keys) {
        const std::uint64_t high = device();
        key = high << 32 | device();
      }
      return keys;
    }();
    keys_ = drawn;
  }
  std::uint64_t operator()(const Vec3f& p) const {
    const std::uint64_t x = std::bit_cast<std::uint32_t>(p.x), y = std::bit_cast<std::uint32_t>(p.y),
                        z = std::bit_cast<std::uint32_t>(p.z);
    using u128 = unsigned __int128;
    const u128 product = static_cast<u128>((x | y << 32) ^ keys_[0]) * (z ^ keys_[1]);
    return static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64);
  }

 private:
  std::array<std::uint64_t, 2> keys_;
};

void fetch(const void* address) {
  __builtin_prefetch(address);
  asm volatile("");  // gcc 12 takes a function that only fetches for one that does nothing
}

/// Positions that were seen, by their bits. Millions of them lie outside of the caches: who says early enough
/// what will be asked for does not wait for it.
class PositionTable {
 public:
  PositionTable(std::size_t most, const std::vector<Vec3f>& positions, const Execution& execution)
      : mask_(std::bit_ceil(2 * most + 1) - 1),
        slots_(filled(execution, mask_ + 1, kNoVertex)),
        positions_(positions) {}

  void fetch_slot(const Vec3f& p) const { fetch(&slots_[hash_(p) & mask_]); }
  /// Once the slot is there.
  void fetch_position(const Vec3f& p) const {
    const VertexId first = slots_[hash_(p) & mask_];
    if (first != kNoVertex) fetch(&positions_[first]);
  }
  /// The place of the vertex at p: kNoVertex where there is none yet.
  VertexId& at(const Vec3f& p, Pacer& pacer) {
    std::size_t slot = hash_(p) & mask_;
    while (slots_[slot] != kNoVertex && !(positions_[slots_[slot]] == p)) {
      pacer.step();
      slot = (slot + 1) & mask_;
    }
    return slots_[slot];
  }

 private:
  const std::size_t mask_;
  std::vector<VertexId> slots_;
  const std::vector<Vec3f>& positions_;  ///< of the vertices; grows
  const PositionHash hash_;
};

/// With one zero: -0 + 0 is +0.
Vec3f with_one_zero(const Vec3f& p) { return {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f}; }

bool finite(const Vec3f& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

/// Triangles between saying what will be needed and needing it: memory answers within some 100 ns, a triangle
/// takes 10 to 30.
constexpr std::size_t kSlotsAhead = 24, kPositionsAhead = 12;

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

}  // namespace

Expected<Surface> weld_exact(const Mesh& mesh, SolidReport& report, const Execution& execution) {
  report.source_triangles = mesh.triangles.size();
  report.source_vertices = mesh.positions.size();
  if (mesh.triangles.empty()) return fail(ErrorCode::kEmptyMesh, "The mesh has no triangles.");

  Surface surface;
  const std::size_t wedge_bound = std::min(mesh.positions.size(), 3 * mesh.triangles.size());
  surface.triangles = filled(execution, mesh.triangles.size(), Triangle{});
  surface.source = filled<std::uint32_t>(execution, mesh.triangles.size(), 0);
  surface.positions.reserve(wedge_bound);
  std::vector<VertexId> vertex_of_wedge = filled(execution, mesh.positions.size(), kNoVertex);
  PositionTable table(wedge_bound, surface.positions, execution);
  // Calls visit(position) for the corners of a later triangle that are new as far as is known now.
  const auto ahead = [&](std::size_t t, const auto& visit) {
    if (t >= mesh.triangles.size()) return;
    for (const std::uint32_t wedge : mesh.triangles[t])
      if (wedge < mesh.positions.size() && vertex_of_wedge[wedge] == kNoVertex)
        visit(with_one_zero(mesh.positions[wedge]));
  };
  Pacer pacer(execution);
  std::uint64_t used_wedges = 0;
  std::size_t kept = 0;

  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    pacer.step();
    ahead(t + kSlotsAhead, [&](const Vec3f& p) { table.fetch_slot(p); });
    ahead(t + kPositionsAhead, [&](const Vec3f& p) { table.fetch_position(p); });
    Triangle triangle;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t wedge = mesh.triangles[t][k];
      if (wedge >= mesh.positions.size())
        return fail(ErrorCode::kMalformedMesh, "Triangle " + std::to_string(t) + " uses vertex " +
                                                   std::to_string(wedge) + " of " +
                                                   std::to_string(mesh.positions.size()) + ".");
      VertexId& vertex = vertex_of_wedge[wedge];
      if (vertex == kNoVertex) {
        const Vec3f p = with_one_zero(mesh.positions[wedge]);
        if (!finite(p))
          return fail(ErrorCode::kNotFinite,
                      "Vertex " + std::to_string(wedge) + " has a coordinate that is NaN or infinite.", {},
                      {{"vertex", wedge}});
        ++used_wedges;
        VertexId& known = table.at(p, pacer);
        if (known == kNoVertex) {
          known = VertexId{surface.positions.size()};
          surface.positions.push_back(p);
        }
        vertex = known;
      }
      triangle[k] = vertex;
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
                                           " triangles are degenerate: two corners at the same position.");
  return surface;
}

bool weld_tolerant(Surface& surface, const EdgeTable& edges, double tolerance, SolidReport& report,
                   const Execution& execution) {
  if (!(tolerance > 0)) return false;
  struct OpenEdge {
    VertexId a, b;
  };
  std::vector<OpenEdge> open;
  std::vector<VertexId> members;
  edges.for_each(execution, [&](VertexId a, VertexId b, std::span<const EdgeUse> uses) {
    if (uses.size() != 1) return;
    make_room(execution, open);
    make_room(execution, members, 2);
    open.push_back({a, b});
    members.push_back(a);
    members.push_back(b);
  });
  sort_with_polls(execution, members.begin(), members.end());
  members.erase(std::unique(members.begin(), members.end()), members.end());
  DisjointSets near = singletons(execution, surface.positions.size());
  unite_near(surface.positions, members, tolerance, near, execution);

  // A cluster is useful when it makes two different open edges meet.
  struct Met {
    VertexId a, b;
    auto operator<=>(const Met&) const = default;
  };
  std::vector<Met> met;
  met.reserve(open.size());
  for_each_polled(execution, open.size(), [&](std::size_t i) {
    const VertexId a{near.find(open[i].a)}, b{near.find(open[i].b)};
    if (a != b) met.push_back({std::min(a, b), std::max(a, b)});
  });
  sort_with_polls(execution, met.begin(), met.end());
  std::vector<std::uint8_t> useful = filled<std::uint8_t>(execution, surface.positions.size(), 0);
  for_each_polled(execution, met.size(), [&](std::size_t i) {
    if (i > 0 && met[i] == met[i - 1]) useful[met[i].a] = useful[met[i].b] = 1;
  });
  std::uint64_t merged = 0;
  std::vector<VertexId> target = filled(execution, surface.positions.size(), kNoVertex);
  for_each_polled(execution, members.size(), [&](std::size_t i) {
    const VertexId v = members[i], root{near.find(v)};
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

}  // namespace fracture::solid_detail
