// Voronoi sites, from harmless to adversarial, for a given mesh.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace fracture::test {

/// Uniform in the box, on a lattice of 2^-21 of its longest side.
std::vector<Vec3d> random_sites(const Box& box, std::uint32_t count, std::uint64_t seed);
/// (n + 1)³ points that include the corners, edges and faces of the box. Bisectors and sites are aligned with
/// a box-shaped mesh.
std::vector<Vec3d> lattice_sites(const Box& box, int n);
/// n³ centres of equal boxes: bisectors are aligned with the faces.
std::vector<Vec3d> centered_lattice_sites(const Box& box, int n);
/// Sites exactly on vertices, edge middles and triangle centroids of the mesh. At most `count` are picked,
/// evenly.
std::vector<Vec3d> sites_on_vertices(const Mesh& mesh, std::uint32_t count);
std::vector<Vec3d> sites_on_edges(const Mesh& mesh, std::uint32_t count);
std::vector<Vec3d> sites_on_faces(const Mesh& mesh, std::uint32_t count);
/// Pairs of mirror images across the planes of (at most `count`) triangles of axis-aligned meshes. So the
/// bisector contains the face.
std::vector<Vec3d> sites_with_bisectors_on_faces(const Mesh& mesh, std::uint32_t count);

struct SiteFamily {
  std::string name;
  std::vector<Vec3d> sites;
};
/// All of the above, plus: one, two, fifty and a thousand random sites; duplicated, coplanar, collinear and
/// cospherical ones; all outside; partly outside; in a cluster of 1e-6 of the box.
std::vector<SiteFamily> site_families(const Mesh& mesh, std::uint64_t seed);
/// The same families with at most 64 sites each, for runs over many meshes.
std::vector<SiteFamily> small_site_families(const Mesh& mesh, std::uint64_t seed);

}  // namespace fracture::test
