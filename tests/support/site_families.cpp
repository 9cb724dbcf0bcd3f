#include "tests/support/site_families.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/random.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

Vec3d lerp(const Box& box, double x, double y, double z) {
  const Vec3d s = box.size();
  return {box.min.x + x * s.x, box.min.y + y * s.y, box.min.z + z * s.z};
}

/// Indices from 0 to total - 1, at most `count` of them, evenly spread.
std::vector<std::size_t> spread(std::size_t total, std::size_t count) {
  std::vector<std::size_t> picked;
  const std::size_t n = std::min(total, count);
  for (std::size_t i = 0; i < n; ++i) picked.push_back(i * total / n);
  return picked;
}

std::vector<SiteFamily> families(const Mesh& mesh, std::uint64_t seed, std::uint32_t many, int lattice) {
  const Box box = box_of(mesh);
  const Vec3d size = box.size();
  std::vector<SiteFamily> all;
  const auto add = [&](std::string name, std::vector<Vec3d> sites) {
    if (!sites.empty()) all.push_back({std::move(name), std::move(sites)});
  };
  add("one", random_sites(box, 1, seed));
  add("two", random_sites(box, 2, seed + 1));
  add("fifty", random_sites(box, 50, seed + 2));
  if (many > 64) add("many", random_sites(box, many, seed + 3));
  add("lattice", lattice_sites(box, lattice));
  add("centered_lattice", centered_lattice_sites(box, lattice));
  add("on_vertices", sites_on_vertices(mesh, many));
  add("on_edges", sites_on_edges(mesh, many));
  add("on_faces", sites_on_faces(mesh, many));
  add("bisectors_on_faces", sites_with_bisectors_on_faces(mesh, many));

  std::vector<Vec3d> duplicated = random_sites(box, 20, seed + 4);
  duplicated.insert(duplicated.end(), duplicated.begin(), duplicated.begin() + 20);
  duplicated.push_back(duplicated.front());
  add("duplicated", duplicated);

  std::vector<Vec3d> coplanar, collinear, cospherical, outside, partly;
  for (const Vec3d& p : random_sites(box, 40, seed + 5)) coplanar.push_back({p.x, p.y, box.center().z});
  for (int i = 0; i < 12; ++i) collinear.push_back(lerp(box, i / 11.0, i / 11.0, i / 11.0));
  for (int i = 0; i < 8; ++i)
    for (int j = 1; j < 4; ++j) {
      const CirclePoint a = circle_point(i, 8), b = circle_point(j, 8);
      const double r = 0.25 * box.longest_side();
      cospherical.push_back(box.center() + r * Vec3d{b.sin * a.cos, b.sin * a.sin, b.cos});
    }
  for (const Vec3d& p : random_sites(box, 16, seed + 6))
    outside.push_back(p + Vec3d{1.25 * size.x, 0, 0.5 * size.z});
  partly = random_sites(box, 16, seed + 7);
  partly.insert(partly.end(), outside.begin(), outside.begin() + 8);
  add("coplanar", coplanar);
  add("collinear", collinear);
  add("cospherical", cospherical);
  add("all_outside", outside);
  add("partly_outside", partly);

  std::vector<Vec3d> cluster;
  for (const Vec3d& p : random_sites(box, 30, seed + 8))
    cluster.push_back(box.center() + 0x1p-20 * (p - box.center()));
  add("cluster", cluster);
  return all;
}

}  // namespace

std::vector<Vec3d> random_sites(const Box& box, std::uint32_t count, std::uint64_t seed) {
  Random random(seed);
  int exponent = 0;
  (void)std::frexp(box.longest_side(), &exponent);
  const double step = std::ldexp(1.0, exponent - 21);
  std::vector<Vec3d> sites;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    const Vec3d p = lerp(box, x, y, z);
    sites.push_back({std::nearbyint(p.x / step) * step, std::nearbyint(p.y / step) * step,
                     std::nearbyint(p.z / step) * step});
  }
  return sites;
}

std::vector<Vec3d> lattice_sites(const Box& box, int n) {
  std::vector<Vec3d> sites;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j)
      for (int k = 0; k <= n; ++k)
        sites.push_back(
            lerp(box, static_cast<double>(i) / n, static_cast<double>(j) / n, static_cast<double>(k) / n));
  return sites;
}

std::vector<Vec3d> centered_lattice_sites(const Box& box, int n) {
  std::vector<Vec3d> sites;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) sites.push_back(lerp(box, (i + 0.5) / n, (j + 0.5) / n, (k + 0.5) / n));
  return sites;
}

std::vector<Vec3d> sites_on_vertices(const Mesh& mesh, std::uint32_t count) {
  std::vector<Vec3d> sites;
  for (const std::size_t v : spread(mesh.positions.size(), count))
    sites.push_back(to_double(mesh.positions[v]));
  return sites;
}

std::vector<Vec3d> sites_on_edges(const Mesh& mesh, std::uint32_t count) {
  std::vector<Vec3d> sites;
  for (const std::size_t t : spread(mesh.triangles.size(), count)) {
    const auto& [a, b, c] = mesh.triangles[t];
    sites.push_back(0.5 * (to_double(mesh.positions[a]) + to_double(mesh.positions[b])));
  }
  return sites;
}

std::vector<Vec3d> sites_on_faces(const Mesh& mesh, std::uint32_t count) {
  std::vector<Vec3d> sites;
  for (const std::size_t t : spread(mesh.triangles.size(), count)) {
    const auto& [a, b, c] = mesh.triangles[t];
    // Weights 1/2, 1/4, 1/4 keep the point exactly on the plane if the plane is parallel to two axes.
    sites.push_back(0.25 * (2.0 * to_double(mesh.positions[a]) + to_double(mesh.positions[b]) +
                            to_double(mesh.positions[c])));
  }
  return sites;
}

std::vector<Vec3d> sites_with_bisectors_on_faces(const Mesh& mesh, std::uint32_t count) {
  std::vector<Vec3d> sites;
  const double depth = 0.125 * box_of(mesh).longest_side();
  for (const std::size_t t : spread(mesh.triangles.size(), count)) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3d p = to_double(mesh.positions[a]), q = to_double(mesh.positions[b]),
                r = to_double(mesh.positions[c]);
    for (int axis = 0; axis < 3; ++axis) {
      if (p[axis] != q[axis] || q[axis] != r[axis]) continue;
      Vec3d site = 0.25 * (2.0 * p + q + r);
      site[axis] = p[axis] + depth;
      sites.push_back(site);
      site[axis] = p[axis] - depth;
      sites.push_back(site);
    }
  }
  return sites;
}

std::vector<SiteFamily> site_families(const Mesh& mesh, std::uint64_t seed) {
  return families(mesh, seed, 1000, 6);
}
std::vector<SiteFamily> small_site_families(const Mesh& mesh, std::uint64_t seed) {
  return families(mesh, seed, 40, 3);
}

}  // namespace fracture::test
