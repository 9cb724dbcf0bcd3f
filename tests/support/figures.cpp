#include "tests/support/figures.hpp"

#include <cmath>
#include <map>
#include <tuple>

namespace fracture::test {

double volume_of(const Mesh& mesh) {
  if (mesh.triangles.empty()) return 0;
  const Vec3d origin = to_double(mesh.positions[mesh.triangles[0][0]]);
  long double six = 0;
  for (const auto& t : mesh.triangles) {
    long double p[3][3];
    for (int k = 0; k < 3; ++k) {
      const Vec3d q = to_double(mesh.positions[t[k]]);
      for (int a = 0; a < 3; ++a) p[k][a] = static_cast<long double>(q[a]) - origin[a];
    }
    six += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) +
           p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
           p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
  }
  return static_cast<double>(six / 6);
}

double area_of(const Mesh& mesh) {
  long double area = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3d a = to_double(mesh.positions[t[0]]), b = to_double(mesh.positions[t[1]]),
                c = to_double(mesh.positions[t[2]]);
    area += length(cross(b - a, c - a)) / 2;
  }
  return static_cast<double>(area);
}

Box box_of(const Mesh& mesh) {
  Box box;
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t) box.add(to_double(mesh.positions[v]));
  return box;
}

std::uint64_t open_directed_edges(const Mesh& mesh) {
  using Key = std::tuple<float, float, float>;
  std::map<std::pair<Key, Key>, std::int64_t> balance;
  const auto key = [&](std::uint32_t v) {
    const Vec3f& p = mesh.positions[v];
    return Key{p.x, p.y, p.z};
  };
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const Key a = key(t[k]), b = key(t[(k + 1) % 3]);
      if (a < b) ++balance[{a, b}];
      if (b < a) --balance[{b, a}];
    }
  std::uint64_t open = 0;
  for (const auto& [edge, count] : balance) open += static_cast<std::uint64_t>(std::llabs(count));
  return open;
}

double winding_number(const Mesh& mesh, const Vec3d& p) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3d a = to_double(mesh.positions[t[0]]) - p, b = to_double(mesh.positions[t[1]]) - p,
                c = to_double(mesh.positions[t[2]]) - p;
    const double la = length(a), lb = length(b), lc = length(c);
    sum +=
        2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return sum / (4 * 3.14159265358979323846);
}

}  // namespace fracture::test
