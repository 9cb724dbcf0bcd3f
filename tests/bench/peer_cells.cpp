#include "tests/bench/peer_cells.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <vector>

namespace fracture::bench {
namespace {

using Polygon = std::vector<Vec3d>;

/// Keeps the part of the convex polyhedron in which dot(normal, x) <= offset, and closes it with one face.
void clip_polyhedron(std::vector<Polygon>& faces, const Vec3d& normal, double offset) {
  std::vector<Polygon> kept;
  Polygon lid;
  for (const Polygon& face : faces) {
    Polygon clipped;
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Vec3d &a = face[i], &b = face[(i + 1) % face.size()];
      const double da = dot(normal, a) - offset, db = dot(normal, b) - offset;
      if (da <= 0) clipped.push_back(a);
      if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
        const Vec3d p = a + (da / (da - db)) * (b - a);
        clipped.push_back(p);
        lid.push_back(p);
      }
    }
    if (clipped.size() >= 3) kept.push_back(std::move(clipped));
  }
  if (lid.size() >= 3) {
    Vec3d center;
    for (const Vec3d& p : lid) center = center + (1.0 / static_cast<double>(lid.size())) * p;
    const Vec3d u = lid[0] - center, v = cross(normal, u);
    std::sort(lid.begin(), lid.end(), [&](const Vec3d& a, const Vec3d& b) {
      return std::atan2(dot(a - center, v), dot(a - center, u)) <
             std::atan2(dot(b - center, v), dot(b - center, u));
    });
    kept.push_back(std::move(lid));
  }
  faces = std::move(kept);
}

std::vector<Vec3d> cell_vertices(const Tetrahedralization& t, SiteId site,
                                 const std::vector<SiteId>& neighbours, const Box& box) {
  const Vec3d grown = 0.1 * box.size(), low = box.min - grown, high = box.max + grown;
  const auto corner = [&](int i) {
    return Vec3d{i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
  };
  std::vector<Polygon> faces;
  for (const auto& quad : {std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4},
                           std::array{2, 6, 7, 3}, std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}})
    faces.push_back({corner(quad[0]), corner(quad[1]), corner(quad[2]), corner(quad[3])});
  const Vec3d p = t.points[site];
  for (const SiteId n : neighbours) {
    const Vec3d q = t.points[n], normal = q - p;
    clip_polyhedron(faces, normal, dot(normal, 0.5 * (p + q)));
  }
  std::vector<Vec3d> vertices;
  for (const Polygon& face : faces) vertices.insert(vertices.end(), face.begin(), face.end());
  std::sort(vertices.begin(), vertices.end(), lexicographic_less);
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

}  // namespace

void write_for_peer(const std::string& path, const Solid& solid, const Tetrahedralization& t) {
  std::vector<std::vector<SiteId>> neighbours(t.site_count());
  for (const Tetrahedron& tet : t.tets)
    for (const SiteId a : tet.v)
      for (const SiteId b : tet.v)
        if (a != b && !t.is_corner(a) && !t.is_corner(b)) neighbours[a].push_back(b);
  std::vector<Vec3d> points;
  std::vector<std::uint32_t> first{0};
  for (const SiteId s : ids<SiteId>(t.site_count())) {
    std::sort(neighbours[s].begin(), neighbours[s].end());
    neighbours[s].erase(std::unique(neighbours[s].begin(), neighbours[s].end()), neighbours[s].end());
    const std::vector<Vec3d> cell = cell_vertices(t, s, neighbours[s], solid.box);
    points.insert(points.end(), cell.begin(), cell.end());
    first.push_back(static_cast<std::uint32_t>(points.size()));
  }
  std::ofstream out(path, std::ios::binary);
  const auto write = [&out](const auto& items) {
    out.write(reinterpret_cast<const char*>(items.data()),
              static_cast<std::streamsize>(items.size() * sizeof(items[0])));
  };
  const std::vector<std::uint32_t> counts{static_cast<std::uint32_t>(solid.positions.size()),
                                          static_cast<std::uint32_t>(solid.triangles.size()), t.site_count(),
                                          static_cast<std::uint32_t>(points.size())};
  write(counts);
  write(points);
  write(solid.positions);
  write(solid.triangles);
  write(first);
}

}  // namespace fracture::bench
