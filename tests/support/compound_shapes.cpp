#include <array>
#include <cmath>

#include "tests/support/assemble.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

/// A grid of i × j points, closed in both directions, as triangles. `turn` identifies (major, j) with (0,
/// turn(j)).
template <class Point, class Turn>
Mesh closed_grid(int major, int minor, Point&& point, Turn&& turn) {
  Mesh mesh;
  for (int i = 0; i < major; ++i)
    for (int j = 0; j < minor; ++j) {
      const Vec3d p = point(i, j);
      mesh.positions.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
    }
  const auto at = [&](int i, int j) {
    j = (j % minor + minor) % minor;
    if (i == major) i = 0, j = (turn(j) % minor + minor) % minor;
    return static_cast<std::uint32_t>(i * minor + j);
  };
  for (int i = 0; i < major; ++i)
    for (int j = 0; j < minor; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  finish(mesh);
  return mesh;
}

}  // namespace

Mesh nested_spheres(int shells, int triangles_each, double spacing) {
  std::vector<Mesh> meshes;
  for (int k = 0; k < shells; ++k) {
    Mesh sphere = sphere_with(triangles_each, 1 - k * spacing);
    meshes.push_back(k % 2 == 0 ? std::move(sphere) : reversed(std::move(sphere)));
  }
  return joined(meshes);
}

Mesh two_cubes_sharing_an_edge() { return joined({box({0, 0, 0}, {1, 1, 1}), box({1, 1, 0}, {2, 2, 1})}); }
Mesh two_cubes_sharing_a_vertex() { return joined({box({0, 0, 0}, {1, 1, 1}), box({1, 1, 1}, {2, 2, 2})}); }
Mesh two_cubes_sharing_a_face() {
  // Mirrored, so that the diagonals of the common face agree.
  return joined(
      {box({0, 0, 0}, {1, 1, 1}), translated(scaled(box({0, 0, 0}, {1, 1, 1}), {-1, 1, 1}), {2, 0, 0})});
}

Mesh cube_field(int n) {
  std::vector<Mesh> cubes;
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) cubes.push_back(box({x + 0., y + 0., z + 0.}, {x + 0.5, y + 0.5, z + 0.5}));
  return joined(cubes);
}

Mesh self_crossing_tube(int major, int minor) {
  // The centre line (cos t, sin 2t, 0) crosses itself at the origin.
  return closed_grid(
      major, minor,
      [=](int i, int j) {
        const CirclePoint t = circle_point(i, major), t2 = circle_point(2 * i, major),
                          b = circle_point(j, minor);
        Vec3d tangent{-t.sin, 2 * t2.cos, 0};
        const double l = length(tangent);
        const Vec3d normal{tangent.y / l, -tangent.x / l, 0};
        return Vec3d{t.cos, t2.sin, 0} + (0.2 * b.cos) * normal + (0.2 * b.sin) * Vec3d{0, 0, 1};
      },
      [](int j) { return j; });
}

Mesh klein_bottle(int major, int minor) {
  // Figure-8 immersion: x = (2 + cos(u/2) sin v - sin(u/2) sin 2v) cos u, …. One turn maps v to -v.
  return closed_grid(
      major, minor,
      [=](int i, int j) {
        const CirclePoint u = circle_point(i, major), half = circle_point(i, 2 * major),
                          v = circle_point(j, minor), v2 = circle_point(2 * j, minor);
        const double r = 2 + half.cos * v.sin - half.sin * v2.sin;
        return Vec3d{r * u.cos, r * u.sin, half.sin * v.sin + half.cos * v2.sin};
      },
      [](int j) { return -j; });
}

Mesh inside_out_cube() { return reversed(cube()); }

Mesh cube_with_seams() {
  const Mesh plain = cube();
  Mesh mesh;
  mesh.attributes.uvs.resize(2);
  for (std::size_t face = 0; face < 6; ++face) {
    const auto& first = plain.triangles[2 * face];
    const auto& second = plain.triangles[2 * face + 1];
    const std::array<std::uint32_t, 4> quad{first[0], first[1], first[2], second[2]};
    const Vec3d a = to_double(plain.positions[quad[0]]);
    const Vec3d n = cross(to_double(plain.positions[quad[1]]) - a, to_double(plain.positions[quad[3]]) - a);
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    constexpr std::array<Vec2f, 4> kUv{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    for (std::size_t k = 0; k < 4; ++k) {
      mesh.positions.push_back(plain.positions[quad[k]]);
      mesh.attributes.normals.push_back(
          {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)});
      mesh.attributes.uvs[0].push_back(kUv[k]);
      mesh.attributes.uvs[1].push_back({kUv[k].x / 8 + static_cast<float>(face) / 8, kUv[k].y});
    }
    mesh.triangles.push_back({base, base + 1, base + 2});
    mesh.triangles.push_back({base, base + 2, base + 3});
  }
  finish(mesh);
  return mesh;
}

Mesh sphere_with_seams(int rings, int segments) {
  Mesh mesh;
  mesh.attributes.uvs.resize(1);
  for (int r = 0; r <= rings; ++r) {
    const CirclePoint polar = circle_point(r, 2 * rings);
    for (int s = 0; s <= segments; ++s) {
      const CirclePoint around = circle_point(s, segments);
      const double ring = r == 0 || r == rings ? 0 : polar.sin;
      const Vec3f p{static_cast<float>(ring * around.cos), static_cast<float>(ring * around.sin),
                    static_cast<float>(r == 0       ? 1
                                       : r == rings ? -1
                                                    : polar.cos)};
      mesh.positions.push_back(p);
      mesh.attributes.normals.push_back(p);
      mesh.attributes.uvs[0].push_back({static_cast<float>(s) / static_cast<float>(segments),
                                        static_cast<float>(r) / static_cast<float>(rings)});
    }
  }
  const auto at = [segments](int r, int s) { return static_cast<std::uint32_t>(r * (segments + 1) + s); };
  for (int r = 0; r < rings; ++r)
    for (int s = 0; s < segments; ++s) {
      if (r + 1 < rings) mesh.triangles.push_back({at(r, s), at(r + 1, s), at(r + 1, s + 1)});
      if (r > 0) mesh.triangles.push_back({at(r, s), at(r + 1, s + 1), at(r, s + 1)});
    }
  // The first row's triangles use the pole of their own segment, and so do the last row's.
  finish(mesh);
  return mesh;
}

Mesh open_quad() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  finish(mesh);
  return mesh;
}

Mesh cube_without(const std::vector<int>& faces) {
  const Mesh whole = cube();
  Mesh mesh = whole;
  mesh.triangles.clear();
  for (std::size_t t = 0; t < whole.triangles.size(); ++t) {
    bool keep = true;
    for (const int face : faces) keep &= static_cast<int>(t / 2) != face;
    if (keep) mesh.triangles.push_back(whole.triangles[t]);
  }
  finish(mesh);
  return mesh;
}

Mesh translated(Mesh mesh, const Vec3d& by) {
  for (Vec3f& p : mesh.positions)
    p = {static_cast<float>(p.x + by.x), static_cast<float>(p.y + by.y), static_cast<float>(p.z + by.z)};
  return mesh;
}

Mesh scaled(Mesh mesh, const Vec3d& by) {
  for (Vec3f& p : mesh.positions)
    p = {static_cast<float>(p.x * by.x), static_cast<float>(p.y * by.y), static_cast<float>(p.z * by.z)};
  return by.x * by.y * by.z < 0 ? reversed(std::move(mesh)) : mesh;
}

Mesh joined(const std::vector<Mesh>& meshes) {
  Mesh all;
  for (const Mesh& mesh : meshes) {
    const auto base = static_cast<std::uint32_t>(all.positions.size());
    all.positions.insert(all.positions.end(), mesh.positions.begin(), mesh.positions.end());
    for (const auto& [a, b, c] : mesh.triangles) all.triangles.push_back({a + base, b + base, c + base});
  }
  finish(all);
  return all;
}

Mesh reversed(Mesh mesh) {
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

Mesh unindexed(const Mesh& mesh) {
  Mesh loose;
  for (const auto& triangle : mesh.triangles) {
    const auto base = static_cast<std::uint32_t>(loose.positions.size());
    for (const std::uint32_t wedge : triangle) loose.positions.push_back(mesh.positions[wedge]);
    loose.triangles.push_back({base, base + 1, base + 2});
  }
  finish(loose);
  return loose;
}

}  // namespace fracture::test
