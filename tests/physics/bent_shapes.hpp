// Solids with notches and openings whose volumes are known by hand: cells of a grid, straight or around an axis.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {

/// Is the cell (i, j, k) solid?
using IsSolid = std::function<bool(int i, int j, int k)>;

/// The surface of cells between planes at x, y and z, each of its rectangles in n × n squares. Cells that touch along an
/// edge alone are not allowed.
inline Mesh grid_solid(const std::array<std::vector<double>, 3>& planes, const IsSolid& is_solid, int n = 1) {
  Mesh mesh;
  std::map<std::array<double, 3>, std::uint32_t> ids;
  const auto count = [&](int axis) {
    return static_cast<int>(planes[static_cast<std::size_t>(axis)].size()) - 1;
  };
  const auto is_filled = [&](const std::array<int, 3>& c) {
    for (int a = 0; a < 3; ++a)
      if (c[static_cast<std::size_t>(a)] < 0 || c[static_cast<std::size_t>(a)] >= count(a)) return false;
    return is_solid(c[0], c[1], c[2]);
  };
  const auto add_square = [&](const std::array<int, 3>& c, std::size_t a, int side, int u, int v) {
    const std::size_t b = (a + 1) % 3, d = (a + 2) % 3;
    const auto corner = [&](int du, int dv) {
      std::array<double, 3> p{};
      p[a] = planes[a][static_cast<std::size_t>(c[a] + side)];
      const auto between = [&](std::size_t axis, int step) {
        const double low = planes[axis][static_cast<std::size_t>(c[axis])];
        const double high = planes[axis][static_cast<std::size_t>(c[axis] + 1)];
        return step == n ? high : low + (high - low) * step / n;
      };
      p[b] = between(b, u + du);
      p[d] = between(d, v + dv);
      const auto [at, is_new] = ids.try_emplace(p, static_cast<std::uint32_t>(mesh.positions.size()));
      if (is_new)
        mesh.positions.push_back(
            {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
      return at->second;
    };
    const std::array<std::uint32_t, 4> q{corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
    if (side == 1) {
      mesh.triangles.push_back({q[0], q[1], q[2]});
      mesh.triangles.push_back({q[0], q[2], q[3]});
    } else {
      mesh.triangles.push_back({q[0], q[2], q[1]});
      mesh.triangles.push_back({q[0], q[3], q[2]});
    }
  };
  std::array<int, 3> c{};
  for (c[0] = 0; c[0] < count(0); ++c[0])
    for (c[1] = 0; c[1] < count(1); ++c[1])
      for (c[2] = 0; c[2] < count(2); ++c[2])
        for (std::size_t a = 0; a < 3 && is_filled(c); ++a)
          for (int side = 0; side < 2; ++side) {
            std::array<int, 3> beside = c;
            beside[a] += 2 * side - 1;
            if (is_filled(beside)) continue;
            for (int u = 0; u < n; ++u)
              for (int v = 0; v < n; ++v) add_square(c, a, side, u, v);
          }
  return mesh;
}

/// The same around the z axis: planes at z, cylinders of `radii` (the first may be 0: the axis), and n sectors, n a multiple
/// of 4. `is_solid` has the numbers of radius, sector and height.
inline Mesh round_solid(const std::vector<double>& radii, int n, const std::vector<double>& z,
                        const IsSolid& is_solid) {
  std::vector<double> sectors;
  for (int k = 0; k <= n; ++k) sectors.push_back(k);
  const Mesh straight = grid_solid({radii, sectors, z}, is_solid);
  Mesh mesh;
  std::map<std::array<float, 3>, std::uint32_t> ids;
  std::vector<std::uint32_t> number;
  for (const Vec3f& p : straight.positions) {
    const int k = p.x == 0 ? 0 : static_cast<int>(p.y) % n;
    const CirclePoint at = circle_point(k, n);
    const Vec3f q{static_cast<float>(p.x * at.cos), static_cast<float>(p.x * at.sin), p.z};
    const auto [found, is_new] =
        ids.try_emplace({p.x, static_cast<float>(k), p.z}, static_cast<std::uint32_t>(mesh.positions.size()));
    if (is_new) mesh.positions.push_back(q);
    number.push_back(found->second);
  }
  const auto in_wall = [&](const std::array<std::uint32_t, 3>& t) {  // of the first and the last sector
    const auto at = [&](std::size_t k) { return static_cast<int>(straight.positions[t[k]].y); };
    return at(0) == at(1) && at(1) == at(2) && (at(0) == 0 || at(0) == n);
  };
  // The walls between the first and the last sector are left out if both are solid: two triangles each.
  std::map<std::array<double, 2>, int> cells;
  const auto cell = [&](const std::array<std::uint32_t, 3>& t) {
    Box box;
    for (const std::uint32_t v : t) box.add(to_double(straight.positions[v]));
    return std::array<double, 2>{box.center().x, box.center().z};
  };
  for (const auto& t : straight.triangles)
    if (in_wall(t)) ++cells[cell(t)];
  for (const auto& t : straight.triangles) {
    if (in_wall(t) && cells[cell(t)] == 4) continue;
    const std::array<std::uint32_t, 3> made{number[t[0]], number[t[1]], number[t[2]]};
    if (made[0] != made[1] && made[1] != made[2] && made[2] != made[0]) mesh.triangles.push_back(made);
  }
  return mesh;
}

}  // namespace fracture::test
