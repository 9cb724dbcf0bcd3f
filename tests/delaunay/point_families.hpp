// Point sets that break Delaunay codes. Each is a deterministic function of its size and a seed.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/random.hpp"
#include "common/base/vec.hpp"

namespace fracture::test {

struct PointFamily {
  std::string name;
  std::vector<Vec3d> (*make)(std::uint32_t n, std::uint64_t seed);
};

inline std::vector<Vec3d> random_cube(std::uint32_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3d> points(n);
  for (Vec3d& p : points)
    for (int a = 0; a < 3; ++a) p[a] = random.uniform();
  return points;
}
/// The first n points of the smallest cubic integer lattice that has as many, divided by `divisor` and
/// shuffled.
inline std::vector<Vec3d> lattice(std::uint32_t n, std::uint64_t seed, double divisor) {
  int side = 1;
  while (static_cast<std::uint32_t>(side * side * side) < n) ++side;
  std::vector<Vec3d> points;
  for (int z = 0; z < side; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side && points.size() < n; ++x)
        points.push_back({x / divisor, y / divisor, z / divisor});
  Random random(seed);
  shuffle(points, random);
  return points;
}

inline std::vector<PointFamily> point_families() {
  return {
      {"random", random_cube},
      {"integer_lattice", [](std::uint32_t n, std::uint64_t seed) { return lattice(n, seed, 1); }},
      {"lattice_of_21sts", [](std::uint32_t n, std::uint64_t seed) { return lattice(n, seed, 21); }},
      {"small_integers_with_duplicates",
       [](std::uint32_t n, std::uint64_t seed) {
         Random random(seed);
         std::vector<Vec3d> points(n);
         for (Vec3d& p : points)
           for (int a = 0; a < 3; ++a) p[a] = static_cast<double>(random.below(4));
         return points;
       }},
      // Integer points on the sphere x^2 + y^2 + z^2 = 5^2 * 13^2: exactly cospherical.
      {"cospherical",
       [](std::uint32_t n, std::uint64_t seed) {
         std::vector<Vec3d> points;
         for (int x = -65; x <= 65; ++x)
           for (int y = -65; y <= 65; ++y)
             for (int z = -65; z <= 65; ++z)
               if (x * x + y * y + z * z == 65 * 65) points.push_back({x * 1.0, y * 1.0, z * 1.0});
         Random random(seed);
         shuffle(points, random);
         if (points.size() > n) points.resize(n);
         return points;
       }},
      {"coplanar",
       [](std::uint32_t n, std::uint64_t seed) {
         Random random(seed);
         std::vector<Vec3d> points(n);
         for (Vec3d& p : points) {
           p.x = static_cast<double>(random.below(64));
           p.y = static_cast<double>(random.below(64));
           p.z = p.x + 2 * p.y;
         }
         return points;
       }},
      {"collinear",
       [](std::uint32_t n, std::uint64_t seed) {
         std::vector<Vec3d> points(n);
         for (std::uint32_t i = 0; i < n; ++i) points[i] = {i * 3.0, i * 1.0, i * -2.0};
         Random random(seed);
         shuffle(points, random);
         return points;
       }},
      // Every point lies an ulp or a few away from one of a few points.
      {"near_duplicates",
       [](std::uint32_t n, std::uint64_t seed) {
         Random random(seed);
         const std::vector<Vec3d> centers = random_cube(n / 8 + 1, seed + 1);
         std::vector<Vec3d> points(n);
         for (Vec3d& p : points) {
           p = centers[random.below(centers.size())];
           for (int a = 0; a < 3; ++a)
             for (std::uint64_t ulps = random.below(3); ulps > 0; --ulps) p[a] = std::nextafter(p[a], 2.0);
         }
         return points;
       }},
      // Two planes extremely close together: tetrahedra of almost zero volume.
      {"slivers",
       [](std::uint32_t n, std::uint64_t seed) {
         Random random(seed);
         std::vector<Vec3d> points(n);
         for (Vec3d& p : points) {
           p.x = static_cast<double>(random.below(16));
           p.y = static_cast<double>(random.below(16));
           p.z = random.below(2) ? 0x1p-40 : 0.0;
         }
         return points;
       }},
      {"skew_lines",
       [](std::uint32_t n, std::uint64_t seed) {
         std::vector<Vec3d> points(n);
         for (std::uint32_t i = 0; i < n; ++i)
           points[i] = i % 2 ? Vec3d{i * 1.0, 0, 0} : Vec3d{n / 2.0, i - n / 2.0, n * 1.0};
         Random random(seed);
         shuffle(points, random);
         return points;
       }},
      // Clusters of size 1e-9 that are far apart: coordinates of very different precision.
      {"clusters",
       [](std::uint32_t n, std::uint64_t seed) {
         Random random(seed);
         const std::vector<Vec3d> centers = random_cube(5, seed + 1);
         std::vector<Vec3d> points(n);
         for (Vec3d& p : points) {
           const Vec3d c = centers[random.below(5)];
           for (int a = 0; a < 3; ++a) p[a] = c[a] + 1e-9 * random.uniform();
         }
         return points;
       }},
      // Coordinates that do not fit into 61 bits together: 1e-16 next to 1e6, as files have it from cos 90
      // degrees.
      {"wide_range",
       [](std::uint32_t n, std::uint64_t seed) {
         Random random(seed);
         std::vector<Vec3d> points(n);
         for (Vec3d& p : points)
           for (int a = 0; a < 3; ++a) {
             const std::uint64_t kind = random.below(4);
             const double v = static_cast<double>(random.below(5)) - 2;
             p[a] = kind == 0 ? v * 6.1e-17 : kind == 1 ? v * 1e-5 : v * 1000;
           }
         return points;
       }},
  };
}

}  // namespace fracture::test
