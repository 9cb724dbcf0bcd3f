// Generated meshes for tests and benchmarks, with figures known from outside: triangles, genus, and the exact
// volume if there is one. Everything is computed with basic arithmetic only (no libm), so every machine makes
// the same mesh.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace fracture::test {

/// cos and sin of 2π k/n, by reduction to an eighth of a turn and the Taylor series (error below 1e-15).
struct CirclePoint {
  double cos, sin;
};
CirclePoint circle_point(std::int64_t k, std::int64_t n);

// -- closed, embedded, one shell
/// 2 · segments · (rings - 1) triangles. The vertices lie on the sphere.
Mesh uv_sphere(int rings, int segments, double radius = 1);
/// The UV sphere closest to this number of triangles: sphere_with(2000) has 1984, sphere_with(20000) has
/// 19800.
Mesh sphere_with(int triangles, double radius = 1);
/// 20 · 4^level triangles.
Mesh ico_sphere(int level, double radius = 1);
/// 2 · major · minor triangles around the z axis.
Mesh torus(int major, int minor, double major_radius = 1, double minor_radius = 0.4);
/// The box [low, high] with n × n squares of two triangles on each face: 12 n² triangles, 6 n² + 2 vertices.
Mesh box(const Vec3d& low, const Vec3d& high, int n = 1);
/// [-1/2, 1/2]³.
Mesh cube(int n = 1);
Mesh tetrahedron();
/// 1 × 1 × thickness.
Mesh thin_plate(double thickness = 0.001, int n = 4);
/// The Menger sponge in the unit cube, welded. Its volume is (20/27)^level, its area 2 (20/9)^level + 4
/// (8/9)^level.
Mesh menger_sponge(int level);

// -- compounds and difficult shapes (compound_shapes.cpp)
/// Concentric spheres with radii 1, 1 - d, 1 - 2d, …, alternately outward and inward: parts with a cavity
/// each.
Mesh nested_spheres(int shells, int triangles_each, double spacing = 0.2);
/// Unit cubes that share one edge, one vertex, or one face (both keep their own copy of it).
Mesh two_cubes_sharing_an_edge();
Mesh two_cubes_sharing_a_vertex();
Mesh two_cubes_sharing_a_face();
/// A grid of n × n × n separate cubes of side 1/2 at spacing 1: n³ parts.
Mesh cube_field(int n);
/// A tube around a figure-eight-like closed curve that passes through itself: closed and oriented, not
/// embedded.
Mesh self_crossing_tube(int major = 96, int minor = 12);
/// A Klein bottle (figure-8 immersion): closed, not orientable.
Mesh klein_bottle(int major = 48, int minor = 24);
Mesh inside_out_cube();
/// The cube with separate wedges on each face, normals and two UV sets: 24 wedges on 8 positions.
Mesh cube_with_seams();
/// A UV sphere with separate wedges for its seam, poles and rows: (rings + 1)(segments + 1) wedges, with
/// normals and UVs.
Mesh sphere_with_seams(int rings, int segments);
Mesh open_quad();
/// The cube without some of its faces (2 triangles each). The faces are in the order -x +x -y +y -z +z.
Mesh cube_without(const std::vector<int>& faces);

// -- helpers
Mesh translated(Mesh mesh, const Vec3d& by);
Mesh scaled(Mesh mesh,
            const Vec3d& by);  ///< a mirroring scale also reverses the triangles, so that they stay outward
Mesh joined(const std::vector<Mesh>& meshes);
/// Reverses every triangle.
Mesh reversed(Mesh mesh);
/// Every triangle with three separate wedges (as in STL).
Mesh unindexed(const Mesh& mesh);

struct NamedMesh {
  std::string name;
  Mesh mesh;
};
/// The closed, embedded shapes above in small sizes. Every property should hold for them.
std::vector<NamedMesh> closed_shapes();

}  // namespace fracture::test
