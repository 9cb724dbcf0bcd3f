// Edges that a fragment's topology uses several times are separated, and no point moves.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <vector>

#include "common/base/random.hpp"
#include "common/fragment/closedness.hpp"
#include "common/fragment/repeated_edges.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/support/assemble.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

using Corners = std::array<std::uint32_t, 3>;

/// A fragment over `vertices` points. Each point is one vertex, and its normal distinguishes it from the
/// others.
Fragment fragment_of(const std::vector<Corners>& triangles, std::uint32_t vertices) {
  Fragment f;
  for (std::uint32_t v = 0; v < vertices; ++v) {
    const auto x = static_cast<float>(v);
    f.positions.push_back({x, x * x, x * x * x});
    f.attributes.normals.push_back({x, 0, 1});
    f.attributes.uvs.resize(1);
    f.attributes.uvs[0].push_back({x, -x});
    f.topology.push_back(v);
  }
  for (const Corners& t : triangles) f.indices.insert(f.indices.end(), t.begin(), t.end());
  f.primitives = {{kNoIndex, 0, static_cast<std::uint32_t>(f.indices.size())}};
  return f;
}

/// Counts repeated uses of directed edges by another method than the code under test.
int repeated_in(const Fragment& f) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  for (std::size_t k = 0; k < f.indices.size(); ++k) {
    const std::size_t next = k % 3 == 2 ? k - 2 : k + 1;
    ++uses[{f.topology[f.indices[k]], f.topology[f.indices[next]]}];
  }
  int repeated = 0;
  for (const auto& [edge, count] : uses) repeated += count - 1;
  return repeated;
}

/// Expects that each edge is used once in each direction. Every corner must have the same place and
/// attributes as before.
void expect_split(const Fragment& before, const Fragment& after) {
  EXPECT_EQ(repeated_in(after), 0);
  EXPECT_EQ(open_edges(after), 0u);
  ASSERT_EQ(after.indices.size(), before.indices.size());
  for (std::size_t k = 0; k < before.indices.size(); ++k) {
    const std::uint32_t was = before.indices[k], is = after.indices[k];
    ASSERT_EQ(after.positions[is], before.positions[was]);
    ASSERT_EQ(after.attributes.normals[is], before.attributes.normals[was]);
    ASSERT_EQ(after.attributes.uvs[0][is], before.attributes.uvs[0][was]);
    ASSERT_LE(after.topology[is], is) << "the first vertex of its copy";
    ASSERT_EQ(after.positions[after.topology[is]], after.positions[is]);
  }
  EXPECT_EQ(after.topology.size(), after.positions.size());
  EXPECT_EQ(after.attributes.normals.size(), after.positions.size());
}

void add_tetrahedron(const std::array<std::uint32_t, 4>& v, std::vector<Corners>& triangles) {
  const auto [a, b, c, d] = v;
  triangles.insert(triangles.end(), {{a, b, c}, {a, c, d}, {a, d, b}, {b, d, c}});
}

TEST(RepeatedEdges, BodiesThatShareAnEdgeComeApartThere) {
  std::vector<Corners> triangles;
  for (std::uint32_t k = 0; k < 5; ++k) add_tetrahedron({0, 1, 2 + 2 * k, 3 + 2 * k}, triangles);
  const Fragment before = fragment_of(triangles, 12);
  ASSERT_EQ(repeated_in(before), 8);
  EXPECT_EQ(open_edges(before), 4u) << "four of the five uses in one direction; those back are as many";
  Fragment f = before;
  ASSERT_TRUE(split_repeated_edges(f));
  expect_split(before, f);
  EXPECT_EQ(f.positions.size(), 20u) << "four more of each end";
}

TEST(RepeatedEdges, WhatIsOnceStaysAsItIs) {
  std::vector<Corners> triangles;
  add_tetrahedron({0, 1, 2, 3}, triangles);
  const Fragment before = fragment_of(triangles, 4);
  Fragment f = before;
  EXPECT_FALSE(split_repeated_edges(f));
  EXPECT_EQ(f.indices, before.indices);
  EXPECT_EQ(f.positions, before.positions);
}

TEST(RepeatedEdges, TrianglesWithTwoCornersAtOneVertexGo) {
  std::vector<Corners> triangles{{2, 3, 2}};
  add_tetrahedron({0, 1, 2, 3}, triangles);
  triangles.insert(triangles.begin() + 3, {0, 0, 1});
  triangles.push_back({1, 2, 2});
  Fragment f = fragment_of(triangles, 4);
  f.primitives = {{0, 0, 3}, {1, 3, 12}, {2, 15, 3}, {3, 18, 3}};
  f.caps = {{0, 3}, {6, 12}};
  ASSERT_EQ(f.indices.size(), 21u);
  EXPECT_GT(open_edges(f), 0u);
  EXPECT_TRUE(split_repeated_edges(f));
  EXPECT_EQ(open_edges(f), 0u);
  EXPECT_EQ(repeated_in(f), 0);
  EXPECT_EQ(f.indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2}));
  ASSERT_EQ(f.primitives.size(), 2u);
  EXPECT_EQ(f.primitives[0].material, 1u);
  EXPECT_EQ(f.primitives[0].first_index, 0u);
  EXPECT_EQ(f.primitives[0].index_count, 9u);
  EXPECT_EQ(f.primitives[1].first_index, 9u);
  EXPECT_EQ(f.primitives[1].index_count, 3u);
  ASSERT_EQ(f.caps.size(), 1u);
  EXPECT_EQ(f.caps[0].first, 3u);
  EXPECT_EQ(f.caps[0].count, 9u);
}

TEST(RepeatedEdges, AnOpenFragmentStaysAsItIs) {
  std::vector<Corners> triangles;
  add_tetrahedron({0, 1, 2, 3}, triangles);
  add_tetrahedron({0, 1, 4, 5}, triangles);
  triangles.pop_back();
  Fragment f = fragment_of(triangles, 6);
  EXPECT_FALSE(split_repeated_edges(f));
  EXPECT_EQ(f.positions.size(), 6u);
  EXPECT_GT(open_edges(f), 0u);
}

// Tetrahedra over a few vertices. Most edges are used many times, in fans that go around several of them.
TEST(RepeatedEdges, RandomHeapsOfTetrahedraComeApart) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Random random(seed);
    const auto vertices = static_cast<std::uint32_t>(5 + random.below(12));
    std::vector<Corners> triangles;
    for (std::uint64_t n = 2 + random.below(40); n > 0; --n) {
      std::array<std::uint32_t, 4> v{};
      std::set<std::uint32_t> taken;
      for (std::uint32_t& k : v) do
          k = static_cast<std::uint32_t>(random.below(vertices));
        while (!taken.insert(k).second);
      add_tetrahedron(v, triangles);
    }
    for (std::size_t k = triangles.size(); k > 1; --k)
      std::swap(triangles[k - 1], triangles[random.below(k)]);
    const Fragment before = fragment_of(triangles, vertices);
    Fragment f = before;
    SCOPED_TRACE(seed);
    if (repeated_in(before) > 0) {
      ASSERT_TRUE(split_repeated_edges(f));
    }
    expect_split(before, f);
  }
}

// The order of the triangles decides how the uses of the edge are paired at first. In half of all orders the
// two bodies are one fan around each end, and the pairs must exchange partners.
TEST(RepeatedEdges, TwoBodiesComeApartInEveryOrderOfTheirTriangles) {
  std::vector<Corners> triangles;
  add_tetrahedron({0, 1, 2, 3}, triangles);
  add_tetrahedron({0, 1, 4, 5}, triangles);
  std::vector<std::size_t> order{0, 2, 4, 6};  // triangles (0, 1, x) and (0, x, 1) of each body
  do {
    std::vector<Corners> ordered;
    for (const std::size_t k : order) ordered.push_back(triangles[k]);
    for (const std::size_t k : {1, 3, 5, 7}) ordered.push_back(triangles[k]);
    const Fragment before = fragment_of(ordered, 6);
    ASSERT_EQ(repeated_in(before), 2);
    Fragment f = before;
    ASSERT_TRUE(split_repeated_edges(f));
    expect_split(before, f);
    EXPECT_EQ(f.positions.size(), 8u);
  } while (std::next_permutation(order.begin(), order.end()));
}

/// The unit cube with one edge rounded by an arc of this radius.
Mesh cube_with_fillet(double radius, int steps) {
  std::vector<std::array<double, 2>> outline{{0, 0}};
  for (int k = 0; k <= steps; ++k) {
    const CirclePoint at = circle_point(k, 4 * steps);
    outline.push_back({1 - radius + radius * at.sin, radius - radius * at.cos});
  }
  outline.push_back({1, 1});
  outline.push_back({0, 1});
  Mesh mesh;
  const auto n = static_cast<std::uint32_t>(outline.size());
  for (const float z : {0.0f, 1.0f})
    for (const auto& [x, y] : outline)
      mesh.positions.push_back({static_cast<float>(x), static_cast<float>(y), z});
  for (std::uint32_t k = 0; k < n; ++k) add_quad(mesh, k, (k + 1) % n, n + (k + 1) % n, n + k);
  for (std::uint32_t k = 1; k + 1 < n; ++k) {
    mesh.triangles.push_back({0, k + 1, k});
    mesh.triangles.push_back({n, n + k, n + k + 1});
  }
  finish(mesh);
  return mesh;
}

// The arc is narrower than a few steps of the seam lattice, so cuts through it have diagonals that coincide.
TEST(RepeatedEdges, FragmentsOfACubeWithATinyFilletHaveNone) {
  std::uint64_t copies = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    FractureParameters p;
    p.sites = 30;
    p.seed = seed;
    const Fractured made = fracture_mesh(cube_with_fillet(1e-5, 39), p);
    for (const Fragment& f : made.set.fragments) {
      EXPECT_EQ(repeated_in(f), 0) << "seed " << seed << ", fragment " << f.id;
      // Copies of one vertex have different topology numbers, but the same place and all the same attributes.
      std::set<std::array<float, 8>> seen;
      for (std::uint32_t v = 0; v < f.positions.size(); ++v) {
        if (f.topology[v] != v) continue;
        const Vec3f &x = f.positions[v], n = f.attributes.normals.empty() ? Vec3f{} : f.attributes.normals[v];
        const Vec2f uv = f.attributes.uvs[0][v];
        copies += !seen.insert({x.x, x.y, x.z, n.x, n.y, n.z, uv.x, uv.y}).second;
      }
    }
    EXPECT_EQ(made.set.certificate.open_edges, 0u);
  }
  EXPECT_GT(copies, 0u) << "the test has lost its point: nothing was to be split";
}

}  // namespace
}  // namespace fracture::test
