#include "tests/support/shapes.hpp"

#include <array>
#include <cmath>
#include <map>

#include "tests/support/assemble.hpp"

namespace fracture::test {

CirclePoint circle_point(std::int64_t k, std::int64_t n) {
  k = ((k % n) + n) % n;
  if (8 * k > 4 * n) {  // the lower half mirrors the upper
    const CirclePoint p = circle_point(n - k, n);
    return {p.cos, -p.sin};
  }
  if (8 * k > 2 * n) {  // a quarter turn back
    if (4 * k == 2 * n) return {-1, 0};
    const CirclePoint p = circle_point(4 * k - n, 4 * n);
    return {-p.sin, p.cos};
  }
  if (8 * k > n) {  // mirrored at the diagonal
    const CirclePoint p = circle_point(n - 4 * k, 4 * n);
    return {p.sin, p.cos};
  }
  const double x = 6.283185307179586477 * static_cast<double>(k) / static_cast<double>(n);
  double cosine = 0, sine = 0, term = 1;
  for (int i = 0; i < 20; ++i) {
    const double sign = i % 4 < 2 ? 1 : -1;
    (i % 2 == 0 ? cosine : sine) += sign * term;
    term = term * x / (i + 1);
  }
  return {cosine, sine};
}

Mesh uv_sphere(int rings, int segments, double radius) {
  Mesh mesh;
  mesh.positions.push_back(to_float({0, 0, radius}));
  for (int r = 1; r < rings; ++r) {
    const CirclePoint polar = circle_point(r, 2 * rings);
    for (int s = 0; s < segments; ++s) {
      const CirclePoint around = circle_point(s, segments);
      mesh.positions.push_back(
          to_float({radius * polar.sin * around.cos, radius * polar.sin * around.sin, radius * polar.cos}));
    }
  }
  const auto south = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.push_back(to_float({0, 0, -radius}));
  const auto at = [segments](int r, int s) {
    return static_cast<std::uint32_t>(1 + (r - 1) * segments + s % segments);
  };
  for (int s = 0; s < segments; ++s) mesh.triangles.push_back({0, at(1, s), at(1, s + 1)});
  for (int r = 1; r + 1 < rings; ++r)
    for (int s = 0; s < segments; ++s) add_quad(mesh, at(r, s), at(r + 1, s), at(r + 1, s + 1), at(r, s + 1));
  for (int s = 0; s < segments; ++s)
    mesh.triangles.push_back({at(rings - 1, s), south, at(rings - 1, s + 1)});
  finish(mesh);
  return mesh;
}

Mesh sphere_with(int triangles, double radius) {
  // segments = 2 · rings: 4 rings (rings - 1) triangles.
  const auto count = [](int rings) { return 4 * rings * (rings - 1); };
  int rings = 2;
  while (count(rings + 1) - triangles <= triangles - count(rings)) ++rings;
  return uv_sphere(rings, 2 * rings, radius);
}

Mesh ico_sphere(int level, double radius) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  std::vector<Vec3d> points{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                            {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<std::array<std::uint32_t, 3>> triangles{
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int l = 0; l < level; ++l) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, fresh] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(points.size()));
      if (fresh) {
        Vec3d m = points[a] + points[b];
        points.push_back((length(points[a]) / length(m)) * m);
      }
      return it->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
  }
  Mesh mesh;
  for (const Vec3d& p : points) mesh.positions.push_back(to_float((radius / length(p)) * p));
  mesh.triangles = std::move(triangles);
  finish(mesh);
  return mesh;
}

Mesh torus(int major, int minor, double major_radius, double minor_radius) {
  Mesh mesh;
  for (int i = 0; i < major; ++i) {
    const CirclePoint a = circle_point(i, major);
    for (int j = 0; j < minor; ++j) {
      const CirclePoint b = circle_point(j, minor);
      const double r = major_radius + minor_radius * b.cos;
      mesh.positions.push_back(to_float({r * a.cos, r * a.sin, minor_radius * b.sin}));
    }
  }
  const auto at = [=](int i, int j) { return static_cast<std::uint32_t>((i % major) * minor + j % minor); };
  for (int i = 0; i < major; ++i)
    for (int j = 0; j < minor; ++j) add_quad(mesh, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  finish(mesh);
  return mesh;
}

Mesh box(const Vec3d& low, const Vec3d& high, int n) {
  Mesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> ids;
  const auto at = [&](std::array<int, 3> i) {
    const auto [it, fresh] = ids.try_emplace(i, static_cast<std::uint32_t>(mesh.positions.size()));
    if (fresh) {
      Vec3d p;
      for (int a = 0; a < 3; ++a)
        p[a] = i[a] == n ? high[a] : low[a] + (high[a] - low[a]) * (static_cast<double>(i[a]) / n);
      mesh.positions.push_back(to_float(p));
    }
    return it->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (int end = 0; end < 2; ++end)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const auto corner = [&](int di, int dj) {
            std::array<int, 3> c{};
            c[axis] = end * n;
            c[(axis + 1) % 3] = i + di;
            c[(axis + 2) % 3] = j + dj;
            return at(c);
          };
          if (end == 1)
            add_quad(mesh, corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
          else
            add_quad(mesh, corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0));
        }
  finish(mesh);
  return mesh;
}

Mesh cube(int n) { return box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, n); }

Mesh tetrahedron() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  finish(mesh);
  return mesh;
}

Mesh thin_plate(double thickness, int n) { return box({0, 0, 0}, {1, 1, thickness}, n); }

Mesh menger_sponge(int level) {
  int n = 1;
  for (int l = 0; l < level; ++l) n *= 3;
  const auto solid = [n](int x, int y, int z) {
    if (x < 0 || y < 0 || z < 0 || x >= n || y >= n || z >= n) return false;
    for (; x > 0 || y > 0 || z > 0; x /= 3, y /= 3, z /= 3)
      if ((x % 3 == 1) + (y % 3 == 1) + (z % 3 == 1) >= 2) return false;
    return true;
  };
  Mesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> ids;
  const auto at = [&](const std::array<int, 3>& i) {
    const auto [it, fresh] = ids.try_emplace(i, static_cast<std::uint32_t>(mesh.positions.size()));
    if (fresh)
      mesh.positions.push_back(to_float(
          {static_cast<double>(i[0]) / n, static_cast<double>(i[1]) / n, static_cast<double>(i[2]) / n}));
    return it->second;
  };
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) {
        if (!solid(x, y, z)) continue;
        for (int axis = 0; axis < 3; ++axis)
          for (int end = 0; end < 2; ++end) {
            std::array<int, 3> neighbour{x, y, z};
            neighbour[axis] += end == 1 ? 1 : -1;
            if (solid(neighbour[0], neighbour[1], neighbour[2])) continue;
            const auto corner = [&](int du, int dv) {
              std::array<int, 3> c{x, y, z};
              c[axis] += end;
              c[(axis + 1) % 3] += du;
              c[(axis + 2) % 3] += dv;
              return at(c);
            };
            if (end == 1)
              add_quad(mesh, corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
            else
              add_quad(mesh, corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0));
          }
      }
  finish(mesh);
  return mesh;
}

std::vector<NamedMesh> closed_shapes() {
  return {{"tetrahedron", tetrahedron()},
          {"cube", cube()},
          {"cube_subdivided", cube(6)},
          {"uv_sphere", sphere_with(2000)},
          {"ico_sphere", ico_sphere(3)},
          {"torus", torus(32, 16)},
          {"menger_1", menger_sponge(1)},
          {"menger_2", menger_sponge(2)},
          {"thin_plate", thin_plate()},
          {"nested_spheres", nested_spheres(4, 400)},
          {"two_cubes_edge", two_cubes_sharing_an_edge()},
          {"two_cubes_vertex", two_cubes_sharing_a_vertex()},
          {"two_cubes_face", two_cubes_sharing_a_face()},
          {"cube_field", cube_field(3)},
          {"sphere_with_seams", sphere_with_seams(16, 32)}};
}

}  // namespace fracture::test
