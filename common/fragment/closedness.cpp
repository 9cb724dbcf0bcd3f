#include "common/fragment/closedness.hpp"

#include <algorithm>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/base/random.hpp"
#include "common/base/scratch.hpp"
#include "common/fragment/float_bits.hpp"

namespace fracture {
namespace {

/// Returns, for each vertex, the first vertex at the same position. Uses a hash table with open addressing.
std::vector<std::uint32_t> weld(const std::vector<Vec3f>& positions, Pacer& pacer) {
  const std::size_t size = std::bit_ceil(2 * positions.size() + 1);
  std::vector<std::uint32_t> table(size, kNoIndex), first(positions.size());
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    const Vec3f& p = positions[v];
    std::size_t slot =
        mix64(mix64(bits_of(p.x) | static_cast<std::uint64_t>(bits_of(p.y)) << 32) + bits_of(p.z)) &
        (size - 1);
    while (table[slot] != kNoIndex && !(positions[table[slot]] == p)) slot = (slot + 1) & (size - 1);
    if (table[slot] == kNoIndex) table[slot] = v;
    pacer.step();
    first[v] = table[slot];
  }
  return first;
}

/// Counts edges between the vertices that `at` assigns to each vertex.
Closedness count_edges(const Fragment& f, const std::vector<std::uint32_t>& at, Pacer& pacer) {
  // Undirected edge -> uses, and uses forwards minus backwards.
  struct Entry {
    std::uint64_t key = ~0ull;
    std::int32_t uses = 0, balance = 0;
  };
  const std::size_t size = std::bit_ceil(2 * f.indices.size() + 1);
  std::vector<Entry> table(size);
  for (std::size_t k = 0; k < f.indices.size(); k += 3) {
    pacer.step(3);
    const std::uint32_t v[3] = {at[f.indices[k]], at[f.indices[k + 1]], at[f.indices[k + 2]]};
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;  // its edges cancel one another
    for (int e = 0; e < 3; ++e) {
      const std::uint64_t a = v[e], b = v[(e + 1) % 3], key = a < b ? a << 32 | b : b << 32 | a;
      std::size_t slot = mix64(key) & (size - 1);
      while (table[slot].key != ~0ull && table[slot].key != key) slot = (slot + 1) & (size - 1);
      table[slot].key = key;
      ++table[slot].uses;
      table[slot].balance += a < b ? 1 : -1;
    }
  }
  Closedness c;
  for (const Entry& e : table) {
    pacer.step();
    c.open_edges += static_cast<std::uint64_t>(std::abs(e.balance));
    if (e.uses > 2) ++c.pinched_edges;
  }
  return c;
}

/// Edges grouped by their lower vertex.
struct EdgesByVertex {
  std::vector<std::uint32_t> begin;  // per vertex
  std::vector<std::uint32_t> higher;
  std::vector<std::uint32_t> last;  // per vertex: lower end of the last edge found that has this higher end
  std::size_t bytes() const { return bytes_of_vectors(begin, higher, last); }
  void release() { release_vectors(begin, higher, last); }
};

struct VertexHash {
  std::uint64_t u, w;
};
struct VertexHashes {
  std::vector<VertexHash> at;
  std::size_t bytes() const { return bytes_of_vectors(at); }
  void release() { release_vectors(at); }
};

/// Counts, in a closed fragment, the repeated uses of edges in one direction, and the triangles with two
/// corners at one vertex.
std::uint64_t count_repeated(const Fragment& f, Pacer& pacer) {
  EdgesByVertex& edges = thread_scratch<EdgesByVertex>();
  const std::size_t vertices = f.positions.size(), triangles = f.indices.size() / 3;
  std::uint64_t repeated = 0;
  // In a closed fragment, every edge is used equally often in both directions, so only uses from the lower
  // to the higher vertex are visited.
  const auto each_edge = [&](const auto& visit) {
    pacer.each(0, triangles, [&](std::size_t t) {
      const std::uint32_t* const k = f.indices.data() + 3 * t;
      const std::uint32_t a = f.topology[k[0]], b = f.topology[k[1]], c = f.topology[k[2]];
      if (a < b) visit(a, b);
      if (b < c) visit(b, c);
      if (c < a) visit(c, a);
    });
  };
  edges.begin.assign(vertices + 2, 0);
  pacer.each(0, triangles, [&](std::size_t t) {
    const std::uint32_t* const k = f.indices.data() + 3 * t;
    const std::uint32_t a = f.topology[k[0]], b = f.topology[k[1]], c = f.topology[k[2]];
    repeated += a == b || b == c || c == a;
    edges.begin[a + 2] += a < b;
    edges.begin[b + 2] += b < c;
    edges.begin[c + 2] += c < a;
  });
  pacer.each(2, vertices + 2, [&](std::size_t v) { edges.begin[v] += edges.begin[v - 1]; });
  edges.higher.resize(edges.begin[vertices + 1]);
  each_edge([&](std::uint32_t low, std::uint32_t high) { edges.higher[edges.begin[low + 1]++] = high; });
  edges.last.assign(vertices, kNoIndex);
  pacer.each(0, vertices, [&](std::size_t low) {
    for (std::uint32_t e = edges.begin[low]; e < edges.begin[low + 1]; ++e) {
      std::uint32_t& last = edges.last[edges.higher[e]];
      repeated += last == low;
      last = static_cast<std::uint32_t>(low);
    }
  });
  return repeated;
}

}  // namespace

Closedness closedness(const Fragment& f, const Execution& execution) {
  Pacer pacer(execution);
  return count_edges(f, weld(f.positions, pacer), pacer);
}

std::uint64_t open_edges(const Fragment& f, const Execution& execution) {
  Pacer pacer(execution);
  // Two hashes, u and w, of each vertex's topological vertex. A directed edge a -> b contributes u_a w_b -
  // u_b w_a, so it cancels its opposite. Around a triangle, the three terms form one cross product.
  std::vector<VertexHash>& at = thread_scratch<VertexHashes>().at;
  at.resize(f.positions.size());
  std::uint64_t misplaced = 0;
  pacer.each(0, at.size(), [&](std::size_t v) {
    const std::uint32_t t = f.topology[v];
    misplaced += !(f.positions[v] == f.positions[t]);
    const std::uint64_t h = mix64(t + kGoldenGamma);
    at[v] = {h ^ (h >> 29), h | 1};
  });
  std::uint64_t sum = 0;
  pacer.each(0, f.indices.size() / 3, [&](std::size_t t) {
    const std::uint32_t* const k = f.indices.data() + 3 * t;
    const VertexHash &a = at[k[0]], &b = at[k[1]], &c = at[k[2]];
    sum += (b.u - a.u) * (c.w - a.w) - (c.u - a.u) * (b.w - a.w);
  });
  if (sum == 0 && misplaced == 0) return count_repeated(f, pacer);
  return std::max(
      {misplaced, count_edges(f, f.topology, pacer).open_edges, closedness(f, execution).open_edges});
}

}  // namespace fracture
