#include "tests/solid/families.hpp"

#include <bit>
#include <cmath>

#include "common/base/random.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

Vec3f rounded(const Vec3d& p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

Mesh finished(Mesh mesh) {
  mesh.material.assign(mesh.triangles.size(), kNoIndex);
  mesh.node.assign(mesh.triangles.size(), 0);
  mesh.node_names = {"family"};
  return mesh;
}

Vec3d random_point(Random& random) {
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  return {x, y, z};
}

/// Bricks of a wall across x. They touch if `gap` is 0.
Mesh wall(int bricks, double gap) {
  const int side = static_cast<int>(std::sqrt(static_cast<double>(bricks)));
  std::vector<Mesh> meshes;
  for (int z = 0; z < side; ++z)
    for (int y = 0; y < side; ++y) {
      const Vec3d low{0, y + 0.5 * (z % 2), z + 0.};
      meshes.push_back(box(low, low + Vec3d{1, 1 - gap, 1 - gap}));
    }
  return joined(meshes);
}

/// A cube of cubes that share their faces. Every second cube is inverted.
Mesh checkerboard(int cubes) {
  const int side = static_cast<int>(std::cbrt(static_cast<double>(cubes)));
  std::vector<Mesh> meshes;
  for (int x = 0; x < side; ++x)
    for (int y = 0; y < side; ++y)
      for (int z = 0; z < side; ++z) {
        const Vec3d low{x + 0., y + 0., z + 0.};
        const Mesh cube = box(low, low + Vec3d{1, 1, 1});
        meshes.push_back((x + y + z) % 2 == 0 ? cube : reversed(cube));
      }
  return joined(meshes);
}

/// Triangles around one edge.
Mesh book(int pages) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0, 0, 1}};
  for (int i = 0; i < pages; ++i) {
    const CirclePoint p = circle_point(i, pages);
    mesh.positions.push_back(rounded({p.cos, p.sin, 0.5}));
    mesh.triangles.push_back({0, 1, static_cast<std::uint32_t>(2 + i)});
  }
  return finished(mesh);
}

/// Tetrahedra around one edge.
Mesh wedges(int count) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0, 0, 1}};
  for (int i = 0; i < count; ++i) {
    const auto b = static_cast<std::uint32_t>(mesh.positions.size());
    for (int k = 0; k < 2; ++k) {
      const CirclePoint p = circle_point(2 * i + k, 2 * count);
      mesh.positions.push_back(rounded({p.cos, p.sin, 0.5}));
    }
    mesh.triangles.insert(mesh.triangles.end(), {{0, 1, b + 1}, {0, b, 1}, {0, b + 1, b}, {1, b, b + 1}});
  }
  return finished(mesh);
}

/// Two vertices that all triangles share.
Mesh bipyramid(int sides) {
  Mesh mesh;
  mesh.positions = {{0, 0, 1}, {0, 0, -1}};
  for (int i = 0; i < sides; ++i) {
    const CirclePoint p = circle_point(i, sides);
    mesh.positions.push_back(rounded({p.cos, p.sin, 0}));
  }
  for (int i = 0; i < sides; ++i) {
    const auto a = static_cast<std::uint32_t>(2 + i), b = static_cast<std::uint32_t>(2 + (i + 1) % sides);
    mesh.triangles.insert(mesh.triangles.end(), {{0, a, b}, {1, b, a}});
  }
  return finished(mesh);
}

/// Separate small triangles all over a cube.
Mesh soup(int triangles) {
  Mesh mesh;
  Random random(5);
  for (int i = 0; i < triangles; ++i) {
    const Vec3d center = random_point(random);
    const auto b = static_cast<std::uint32_t>(mesh.positions.size());
    for (int k = 0; k < 3; ++k) mesh.positions.push_back(rounded(center + 0.01 * random_point(random)));
    mesh.triangles.push_back({b, b + 1, b + 2});
  }
  return finished(mesh);
}

/// A soup whose points are all within the weld tolerance, because a far cube makes the box's diagonal long.
Mesh soup_within_the_tolerance(int triangles) {
  return joined({soup(triangles), translated(cube(), {10'000, 0, 0})});
}

/// Two clouds of points in neighbouring cells. Their distance is just over the weld tolerance.
Mesh soups_just_beyond_the_tolerance(int triangles) {
  const Mesh half = scaled(soup(triangles / 2), {1, 1, 1e-4});
  return joined({half, translated(half, {0, 0, 1.01}), translated(cube(), {10'000, 0, 0})});
}

/// A wall between two closed curves of n corners each, one above the other: two holes of n sides.
template <class Curve>
Mesh band(int n, Curve&& curve) {
  Mesh mesh;
  for (int i = 0; i < n; ++i) {
    const auto [low, high] = curve(i);
    mesh.positions.push_back(rounded(low));
    mesh.positions.push_back(rounded(high));
  }
  for (int i = 0; i < n; ++i) {
    const auto a = static_cast<std::uint32_t>(2 * i), b = static_cast<std::uint32_t>(2 * ((i + 1) % n));
    mesh.triangles.insert(mesh.triangles.end(), {{a, b, b + 1}, {a, b + 1, a + 1}});
  }
  return finished(mesh);
}

Mesh star(int n) {
  Random random(9);
  return band(n, [&](int i) {
    const CirclePoint p = circle_point(i, n);
    const double r = 0.2 + random.uniform();
    return std::pair{Vec3d{r * p.cos, r * p.sin, 0}, Vec3d{r * p.cos, r * p.sin, 1}};
  });
}
Mesh lissajous(int n) {
  return band(n, [&](int i) {
    const CirclePoint p = circle_point(std::int64_t{3} * i, n), q = circle_point(std::int64_t{2} * i, n);
    return std::pair{Vec3d{p.cos, q.sin, 0}, Vec3d{p.cos, q.sin, 1}};
  });
}
Mesh tangle(int n) {
  Random random(11);
  return band(n, [&](int) {
    const Vec3d p = random_point(random);
    return std::pair{p, p + Vec3d{0, 0, 1}};
  });
}
/// Corners crowd at one place of a curve that is otherwise wide.
Mesh crowded_star(int n) {
  Random random(13);
  return band(n, [&](int i) {
    const CirclePoint p = circle_point(i, n);
    const double r = i == 0 ? 1e6 : 0.2 + random.uniform();
    return std::pair{Vec3d{r * p.cos, r * p.sin, 0}, Vec3d{r * p.cos, r * p.sin, 1}};
  });
}

/// A cube of 12 n² triangles without every fifth triangle.
Mesh sieve(int triangles) {
  const Mesh whole = cube(static_cast<int>(std::sqrt(triangles / 12.0)));
  Mesh mesh = whole;
  mesh.triangles.clear();
  Random random(8);
  for (const auto& t : whole.triangles)
    if (random.below(5) > 0) mesh.triangles.push_back(t);
  return finished(mesh);
}

/// The same sphere many times. Some of the copies are inverted.
Mesh copies(int triangles) {
  const Mesh sphere = sphere_with(2000);
  std::vector<Mesh> meshes;
  for (int i = 0; i < triangles / 2000; ++i) meshes.push_back(i % 3 == 2 ? reversed(sphere) : sphere);
  return joined(meshes);
}

/// A sphere with half of its triangles facing inwards.
Mesh disoriented(int triangles) {
  Mesh mesh = sphere_with(triangles);
  Random random(3);
  for (auto& t : mesh.triangles)
    if (random.below(2) == 0) std::swap(t[1], t[2]);
  return mesh;
}

Mesh flat_sheet(int n) {
  Mesh mesh;
  const auto at = [n](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) mesh.positions.push_back({static_cast<float>(i), static_cast<float>(j), 0});
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      mesh.triangles.insert(mesh.triangles.end(), {{at(i, j), at(i + 1, j), at(i + 1, j + 1)},
                                                   {at(i, j), at(i + 1, j + 1), at(i, j + 1)}});
  return finished(mesh);
}
int side_of(int triangles) { return static_cast<int>(std::sqrt(triangles / 2.0)); }

/// Parts with a cavity each, and parallel bars whose boxes all touch. Half of the bars are inverted.
Mesh hollow_boxes(int count) {
  std::vector<Mesh> meshes;
  for (int i = 0; i < count; ++i) {
    meshes.push_back(translated(cube(), {2. * (i % 100), 2. * (i / 100), 0}));
    meshes.push_back(
        reversed(translated(scaled(cube(), {0.5, 0.5, 0.5}), {2. * (i % 100), 2. * (i / 100), 0})));
  }
  return joined(meshes);
}
Mesh nested_cubes(int count) {
  std::vector<Mesh> meshes;
  for (int i = 0; i < count; ++i) {
    const Mesh shell = scaled(cube(), {1. + i, 1. + i, 1. + i});
    meshes.push_back(i % 2 == 0 ? shell : reversed(shell));
  }
  return joined(meshes);
}
Mesh diagonal_bars(int count) {
  std::vector<Mesh> meshes;
  for (int i = 0; i < count; ++i) {
    Mesh bar = box({0, 0, 0}, {1, 1, 1});
    for (Vec3f& p : bar.positions)
      p = rounded({0.01 * i + 0.005 * p.x, 200. * p.z + 0.005 * p.y, 200. * p.z - 0.005 * p.y});
    meshes.push_back(i % 2 == 0 ? bar : reversed(bar));
  }
  return joined(meshes);
}

}  // namespace

Mesh sheet_with_a_folded_corner(int n) {
  Mesh mesh = flat_sheet(n);
  // The sheet's side from (1, 0) to (0, 0) gets a triangle with apex v. A second triangle of the same area is
  // folded over it. No other triangle has the vertex v.
  const auto p = mesh.triangles[0][1], q = mesh.triangles[0][0];
  const auto v = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.push_back({1, -1, 0});
  mesh.positions.push_back({0, 0.5f, 0});  // (0, 0) + (p - v) / 2
  mesh.triangles.push_back({p, q, v});
  mesh.triangles.push_back({p, v, v + 1});
  return finished(mesh);
}

std::vector<GrowingFamily> growing_families() {
  const SolidOptions thick{.thickness = 1e-3}, loose{.weld_tolerance = 1e-3}, none{};
  return {
      {"sphere", [](int n) { return sphere_with(n); }, 200'000, none},
      {"sphere without shared vertices", [](int n) { return unindexed(sphere_with(n)); }, 200'000, none},
      {"wall", [](int n) { return wall(n / 12, 0.1); }, 200'000, none},
      {"wall of touching bricks", [](int n) { return wall(n / 12, 0); }, 200'000, none},
      {"checkerboard", [](int n) { return checkerboard(n / 12); }, 200'000, none},
      {"book", book, 200'000, none},
      {"wedges", [](int n) { return wedges(n / 4); }, 200'000, none},
      {"bipyramid", [](int n) { return bipyramid(n / 2); }, 200'000, none},
      {"soup", soup, 200'000, none},
      {"soup of slabs", soup, 60'000, thick},
      {"soup within the tolerance", soup_within_the_tolerance, 100'000, loose},
      {"soups just beyond the tolerance", soups_just_beyond_the_tolerance, 60'000, {.weld_tolerance = 1e-4}},
      {"star", [](int n) { return star(n / 2); }, 200'000, none},
      {"crowded star", [](int n) { return crowded_star(n / 2); }, 200'000, none},
      {"lissajous", [](int n) { return lissajous(n / 2); }, 200'000, none},
      {"tangle", [](int n) { return tangle(n / 2); }, 200'000, none},
      {"sieve", sieve, 200'000, none},
      {"copies", copies, 200'000, none},
      {"disoriented sphere", disoriented, 200'000, none},
      {"sheet", [](int n) { return flat_sheet(side_of(n)); }, 200'000, thick},
      {"sheet with a folded corner", [](int n) { return sheet_with_a_folded_corner(side_of(n)); }, 200'000,
       thick},
      {"hollow boxes", [](int n) { return hollow_boxes(n / 24); }, 200'000, none},
      {"nested cubes", [](int n) { return nested_cubes(n / 12); }, 200'000, none},
      {"diagonal bars", [](int n) { return diagonal_bars(n / 12); }, 120'000, none},
  };
}

}  // namespace fracture::test
