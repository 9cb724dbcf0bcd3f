// Compares nesting with its definition, and measures the work it takes.
#include "common/solid/winding.hpp"

#include <gtest/gtest.h>

#include <map>

#include "common/base/random.hpp"
#include "common/solid/edges.hpp"
#include "common/solid/float_predicates.hpp"
#include "common/solid/nesting.hpp"
#include "common/solid/nesting_forest.hpp"
#include "common/solid/solid.hpp"
#include "tests/support/poll_gaps.hpp"
#include "tests/support/repetitions.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::solid_detail {
namespace {

using test::PollGaps;

/// The mesh as a surface of closed shells. Each shell keeps its own vertices.
Surface surface_of(const Mesh& mesh) {
  Surface surface;
  surface.positions = mesh.positions;
  for (const auto& t : mesh.triangles)
    surface.triangles.push_back({VertexId{t[0]}, VertexId{t[1]}, VertexId{t[2]}});
  surface.source.resize(mesh.triangles.size());
  EXPECT_TRUE(pair_closed_manifold(surface, {}));
  return surface;
}

/// The expected result of WindingNumbers::around() for shell `self`, by rays tested against all triangles one
/// by one.
std::map<std::uint32_t, int> winds_by_definition(const Surface& surface, const Shells& shells,
                                                 std::uint32_t self) {
  const auto side = [](const Vec3f& a, const Vec3f& b, const Vec3f& p) {
    const int sign = sign_orient2d(drop_axis(a, 0), drop_axis(b, 0), drop_axis(p, 0));
    return sign != 0 ? sign : a.z != b.z ? (a.z > b.z ? 1 : -1) : b.y > a.y ? 1 : b.y < a.y ? -1 : 0;
  };
  std::map<std::uint32_t, int> winds;
  int probes = 0;
  for (const TriangleId probe : ids<TriangleId>(surface.triangles.size())) {
    if (shells.of_triangle[probe] != self || probes++ >= 64) continue;
    for (const VertexId v : surface.triangles[probe]) {
      const Vec3f& p = surface.positions[v];
      winds.clear();
      bool clear = true;
      for (const TriangleId t : ids<TriangleId>(surface.triangles.size())) {
        if (shells.of_triangle[t] == self) continue;
        const Vec3f &a = surface.positions[surface.triangles[t][0]],
                    &b = surface.positions[surface.triangles[t][1]],
                    &c = surface.positions[surface.triangles[t][2]];
        const int ab = side(a, b, p);
        if (ab != side(b, c, p) || ab != side(c, a, p)) continue;
        // A segment parallel to x counts only if p lies on it.
        if (ab == 0 &&
            (a.y != p.y || a.z != p.z || std::max({a.x, b.x, c.x}) < p.x || std::min({a.x, b.x, c.x}) > p.x))
          continue;
        const int height = sign_orient3d(a, b, c, p);
        clear &= height != 0;
        if (height * ab < 0) winds[shells.of_triangle[t]] += ab;
      }
      std::erase_if(winds, [&](const auto& w) { return w.second == 0 || shells.list[w.first].flat; });
      if (clear) return winds;
    }
  }
  return winds;
}

/// Boxes and tetrahedra on a small lattice, half of them inverted. Many touch, cross, contain or repeat one
/// another.
Mesh lattice_shells(std::uint64_t seed) {
  Random random(seed);
  const std::uint64_t lattice = 2 + random.below(5), count = 2 + random.below(30);
  const auto place = [&] {
    const auto x = static_cast<double>(random.below(lattice)), y = static_cast<double>(random.below(lattice)),
               z = static_cast<double>(random.below(lattice));
    return Vec3d{x, y, z};
  };
  std::vector<Mesh> shells;
  for (std::uint64_t i = 0; i < count; ++i) {
    Mesh shell;
    if (random.below(2) == 0) {
      const Vec3d low = place();
      shell = test::box(low, low + place() + Vec3d{1, 1, 1}, static_cast<int>(1 + 2 * random.below(2)));
    } else {
      shell = test::tetrahedron();
      for (Vec3f& p : shell.positions) {
        const Vec3d q = place();
        p = {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)};
      }
    }
    shells.push_back(random.below(2) == 0 ? shell : test::reversed(shell));
  }
  return test::joined(shells);
}

TEST(WindingNumbers, AreThoseOfRaysAgainstAllTriangles) {
  for (std::uint64_t seed = 0; seed < static_cast<std::uint64_t>(test::repetitions(300)); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Surface surface = surface_of(lattice_shells(seed));
    const Shells shells = find_shells(surface, {});
    const Execution execution;
    WindingNumbers numbers(surface, shells, execution);
    for (std::uint32_t i = 0; i < shells.list.size(); ++i) {
      if (shells.list[i].flat) continue;
      std::map<std::uint32_t, int> winds;
      for (const auto& [shell, number] : numbers.around(i)) winds[shell] = number;
      ASSERT_EQ(winds, winds_by_definition(surface, shells, i)) << "shell " << i;
    }
  }
}

TEST(WindingNumbers, AreTheSameHoweverOftenALargeShellIsAsked) {
  // The first queries test its triangles one by one. Later queries use a tree.
  std::vector<Mesh> meshes{test::sphere_with(2000, 10)};
  for (int i = 0; i < 20; ++i) meshes.push_back(test::translated(test::cube(), {i - 10 + 0.25, 0, 0}));
  const Surface surface = surface_of(test::joined(meshes));
  const Shells shells = find_shells(surface, {});
  const Execution execution;
  WindingNumbers numbers(surface, shells, execution);
  for (std::uint32_t i = 1; i <= 20; ++i) {
    const bool inside = shells.list[i].box.max.x < 10 && shells.list[i].box.min.x > -10;
    if (!inside) continue;
    ASSERT_EQ(numbers.around(i).size(), 1u) << i;
    EXPECT_EQ(numbers.around(i)[0].number, 1);
  }
}

// -- the forest of shells that do not touch

/// Random boxes and spheres within boxes: `depth` generations, with up to three in each box. Every shell
/// faces in or out at random.
void add_nest(std::vector<Mesh>& shells, const Vec3d& low, double side, int depth, Random& random) {
  Mesh shell = random.below(3) == 0
                   ? test::translated(test::sphere_with(100, 0.499 * side),
                                      low + Vec3d{0.5 * side, 0.5 * side, 0.5 * side})
                   : test::box(low, low + Vec3d{side, side, side}, static_cast<int>(1 + random.below(3)));
  shells.push_back(random.below(2) == 0 ? shell : test::reversed(shell));
  if (depth == 0) return;
  // A central cube of this side also fits into the ball. Its octants do not touch.
  const double inner = 0.2 * side;
  for (std::uint64_t k = random.below(4); k > 0; --k) {
    const std::uint64_t octant = 2 * k + random.below(2);
    const Vec3d corner = low + side * Vec3d{0.28 + 0.24 * static_cast<double>(octant & 1),
                                            0.28 + 0.24 * static_cast<double>(octant >> 1 & 1),
                                            0.28 + 0.24 * static_cast<double>(octant >> 2)};
    add_nest(shells, corner, inner, depth - 1, random);
  }
}

std::optional<NestingForest> forest_of(const Surface& surface, const Shells& shells) {
  const Execution execution;
  WindingNumbers windings(surface, shells, execution);
  return find_nesting_forest(surface, shells, windings, execution);
}

TEST(NestingForest, ItsAncestorsAreTheShellsThatWindAround) {
  std::size_t deepest = 0;
  for (std::uint64_t seed = 0; seed < static_cast<std::uint64_t>(test::repetitions(60)); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    std::vector<Mesh> meshes;
    for (int i = 0; i < 3; ++i) add_nest(meshes, {20. * i, 1. * i, 0}, 16, 5, random);
    const Surface surface = surface_of(test::joined(meshes));
    const Shells shells = find_shells(surface, {});
    const std::optional<NestingForest> forest = forest_of(surface, shells);
    ASSERT_TRUE(forest);
    for (std::uint32_t i = 0; i < shells.list.size(); ++i) {
      std::map<std::uint32_t, int> ancestors;
      for (std::uint32_t s = i; forest->up[s] != kNoIndex; s = forest->up[s])
        ancestors[forest->up[s]] = forest->number[s];
      ASSERT_EQ(ancestors, winds_by_definition(surface, shells, i)) << "shell " << i;
      deepest = std::max(deepest, ancestors.size());
    }
  }
  EXPECT_GE(deepest, 4u);
}

TEST(NestingForest, ThereIsNoneWhereShellsTouchOrCross) {
  const Mesh large = test::box({0, 0, 0}, {4, 4, 4});
  for (const Mesh& other : {test::box({0, 1, 1}, {1, 2, 2}), test::box({3, 3, 3}, {5, 5, 5}),
                            test::translated(test::tetrahedron(), {4, 4, 4}), large}) {
    const Surface surface = surface_of(test::joined({large, other}));
    EXPECT_FALSE(forest_of(surface, find_shells(surface, {})));
  }
}

TEST(NestingForest, DeepNestsBecomePartsWithOneCavityEach) {
  std::vector<Mesh> meshes;
  constexpr int kDepth = 2000;
  for (int i = 0; i < kDepth; ++i) {
    const Mesh cube = test::scaled(test::cube(), {1. + i, 1. + i, 1. + i});
    meshes.push_back(i % 2 == 1 ? cube : test::reversed(cube));
  }
  const Surface surface = surface_of(test::joined(meshes));
  const Nesting nesting = nest_shells(surface, find_shells(surface, {}), {});
  for (std::uint32_t i = 0; i < kDepth; ++i) {
    ASSERT_FALSE(nesting.reversed[i]) << i;
    ASSERT_EQ(nesting.cavity_of[i], i % 2 == 1 ? kNoIndex : i + 1);
  }
}

// -- work, in polls; a poll counts for some thousand steps

/// A parallelepiped with three edge vectors.
Mesh slanted_box(const Vec3d& origin, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  Mesh mesh = test::box({0, 0, 0}, {1, 1, 1});
  for (Vec3f& p : mesh.positions) {
    const Vec3d q =
        origin + static_cast<double>(p.x) * a + static_cast<double>(p.y) * b + static_cast<double>(p.z) * c;
    p = {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)};
  }
  return mesh;
}
Mesh inside_out_cube_apart() { return test::translated(test::inside_out_cube(), {-5, -5, -5}); }

/// Thin bars along a diagonal. Their boxes contain one another's corners. If `half_reversed`, every second
/// bar is inverted.
Mesh diagonal_bars(int count, const Vec3d& along, bool half_reversed) {
  const Vec3d up = std::fabs(along.x) > 0 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
  Vec3d across = cross(along, up);
  across = (1 / length(across)) * across;
  Vec3d third = cross(along, across);
  third = (1 / length(third)) * third;
  std::vector<Mesh> bars{inside_out_cube_apart()};
  for (int i = 0; i < count; ++i) {
    bars.push_back(slanted_box(0.01 * i * across, 100.0 * along, 0.004 * across, 0.004 * third));
    if (half_reversed && i % 2 == 1) bars.back() = test::reversed(bars.back());
  }
  return test::joined(bars);
}

std::uint64_t polls_of_nesting(const Mesh& mesh) {
  const Surface surface = surface_of(mesh);
  const Shells shells = find_shells(surface, {});
  PollGaps gaps;
  nest_shells(surface, shells, gaps.execution());
  return gaps.polls();
}

TEST(NestingWork, TenThousandThinDiagonalBoxesAndAnInsideOutCubeAreASolid) {
  std::vector<Mesh> meshes{inside_out_cube_apart()};
  for (int i = 0; i < 10'000; ++i)
    meshes.push_back(slanted_box({0.01 * i, 0, 0}, {0.004, 0, 0}, {0, 100, 100}, {0, -0.004, 0.004}));
  const Expected<Solid> solid = make_solid(std::make_shared<const Mesh>(test::joined(meshes)), {}, {});
  ASSERT_TRUE(solid);
  EXPECT_EQ(solid->parts.size(), 10'001u);
  EXPECT_EQ(solid->report.flipped, 12u);
}

TEST(NestingWork, BarsSideBySideAreNearLinearHoweverTheyAreTurned) {
  for (const Vec3d& along : {Vec3d{0, 1, 1}, Vec3d{1, 1, 1}, Vec3d{1, 2, 3}, Vec3d{0.3, 1, -0.7}})
    for (const bool half_reversed : {false, true}) {
      SCOPED_TRACE(std::to_string(along.y) + (half_reversed ? ", half of them inside out" : ""));
      const std::uint64_t few = polls_of_nesting(diagonal_bars(1000, along, half_reversed)),
                          many = polls_of_nesting(diagonal_bars(8000, along, half_reversed));
      EXPECT_GT(many, 20u) << "work is polled";
      EXPECT_LT(many, 12 * few + 20);
    }
}

TEST(NestingWork, CavitiesInOneShellAreNearLinear) {
  const auto sponge = [](int side) {
    std::vector<Mesh> meshes{test::box({-1, -1, -1}, {side + 1., side + 1., side + 1.}, side)};
    for (int x = 0; x < side; ++x)
      for (int y = 0; y < side; ++y)
        for (int z = 0; z < side; ++z)
          meshes.push_back(
              test::reversed(test::box({x + 0.1, y + 0.1, z + 0.1}, {x + 0.9, y + 0.9, z + 0.9})));
    return test::joined(meshes);
  };
  const std::uint64_t few = polls_of_nesting(sponge(10)), many = polls_of_nesting(sponge(20));
  EXPECT_GT(many, 20u) << "work is polled";
  EXPECT_LT(many, 12 * few + 20);
}

TEST(NestingWork, ShellsWithinShellsAreNearLinear) {
  const auto cubes = [](int depth) {
    std::vector<Mesh> meshes;
    for (int i = 0; i < depth; ++i) {
      const Mesh cube = test::scaled(test::cube(), {1. + i, 1. + i, 1. + i});
      meshes.push_back(i % 2 == 0 ? cube : test::reversed(cube));
    }
    return test::joined(meshes);
  };
  const auto spheres = [](int depth) { return test::nested_spheres(depth, 200, 0.9 / depth); };
  EXPECT_LT(polls_of_nesting(cubes(8000)), 8 * polls_of_nesting(cubes(2000)));
  EXPECT_LT(polls_of_nesting(spheres(1000)), 8 * polls_of_nesting(spheres(250)));
}

TEST(NestingWork, ShellsThatShareACornerAreNearLinear) {
  const auto spikes = [](int count) {
    std::vector<Mesh> meshes;
    for (int i = 0; i < count; ++i) {
      const test::CirclePoint p = test::circle_point(i, count), q = test::circle_point(2 * i + 1, 2 * count);
      Mesh spike = test::tetrahedron();
      spike.positions = {{0, 0, 0},
                         {0, static_cast<float>(p.cos), static_cast<float>(p.sin)},
                         {0, static_cast<float>(q.cos), static_cast<float>(q.sin)},
                         {1, 0, 0}};
      meshes.push_back(i % 2 == 0 ? spike : test::reversed(spike));
    }
    return test::joined(meshes);
  };
  const std::uint64_t few = polls_of_nesting(spikes(1000)), many = polls_of_nesting(spikes(8000));
  EXPECT_GT(many, 20u) << "work is polled";
  EXPECT_LT(many, 12 * few + 20);
}

}  // namespace
}  // namespace fracture::solid_detail
