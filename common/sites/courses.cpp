#include "common/sites/courses.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"

namespace fracture::sites_detail {
namespace {

constexpr double kTouch = 0.02;  // share of a cell's side; see lay()

}  // namespace

Courses::Courses(const Box& box, const Vec3d& brick, BrickPattern::Bond bond, bool exactly)
    : along_(box.size().x >= box.size().z ? 0 : 2), split_(cells_of_brick(bond)) {
  Vec3d sides;
  sides[along_] = brick.x;
  sides[1] = brick.y;
  sides[2 - along_] = brick.z;
  for (int a = 0; a < 3; ++a)
    d_[static_cast<std::size_t>(a)] =
        exactly ? covering(box.min[a], box.max[a], sides[a]) : fitted(box.min[a], box.max[a], sides[a]);
  Division& along = d_[static_cast<std::size_t>(along_)];
  along.count *= split_;
  along.step /= split_;
}

std::vector<bool> Courses::cells_met(const Task& task, ColumnSampler& sampler,
                                     const std::vector<bool>& of_parts) const {
  const Solid& solid = task.solid;
  Pacer pacer(task.execution);
  std::vector<bool> met(static_cast<std::size_t>(cells()), false);
  const auto in_cells = [&](VertexId v) {
    Vec3d p = to_double(solid.positions[v]);
    for (int a = 0; a < 3; ++a) {
      const Division& d = d_[static_cast<std::size_t>(a)];
      p[a] = d.step > 0 ? (p[a] - d.start) / d.step : 0.5;
    }
    return p;
  };
  constexpr double kHalf = 0.5 - kTouch;
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    pacer.step(4);
    if (!of_parts[solid.part[t]]) continue;
    const Vec3d p = in_cells(solid.triangles[t][0]), q = in_cells(solid.triangles[t][1]),
                r = in_cells(solid.triangles[t][2]);
    std::array<std::uint32_t, 3> first{}, end{};
    for (int a = 0; a < 3; ++a) {
      const auto k = static_cast<std::size_t>(a);
      const double most = d_[k].count, low = std::fmin(std::fmin(p[a], q[a]), r[a]),
                   high = std::fmax(std::fmax(p[a], q[a]), r[a]);
      first[k] = static_cast<std::uint32_t>(std::clamp(std::ceil(low - 1 + kTouch), 0.0, most));
      end[k] = static_cast<std::uint32_t>(std::clamp(std::floor(high - kTouch) + 1, 0.0, most));
    }
    // Among the cells that overlap the triangle's box, mark those that the triangle's plane cuts.
    const Vec3d n = cross(q - p, r - p);
    const double reach = kHalf * (std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z)), at = dot(n, p);
    for (std::uint32_t z = first[2]; z < end[2]; ++z)
      for (std::uint32_t y = first[1]; y < end[1]; ++y)
        for (std::uint32_t x = first[0]; x < end[0]; ++x) {
          pacer.step();
          if (std::fabs(dot(n, {x + 0.5, y + 0.5, z + 0.5}) - at) <= reach) met[index(x, y, z)] = true;
        }
  }
  std::vector<Vec3d> middles;
  std::vector<std::size_t> asked;
  for (std::uint32_t z = 0; z < d_[2].count; ++z)
    for (std::uint32_t y = 0; y < d_[1].count; ++y)
      for (std::uint32_t x = 0; x < d_[0].count; ++x) {
        pacer.step();
        if (met[index(x, y, z)]) continue;
        middles.push_back({d_[0].start + (x + 0.5) * d_[0].step, d_[1].start + (y + 0.5) * d_[1].step,
                           d_[2].start + (z + 0.5) * d_[2].step});
        asked.push_back(index(x, y, z));
      }
  if (!middles.empty()) {
    const std::vector<bool> inside = sampler.inside(middles);
    for (std::size_t k = 0; k < asked.size(); ++k)
      if (inside[k]) met[asked[k]] = true;
  }
  return met;
}

void Courses::lay(const Task& task, ColumnSampler& sampler, const std::vector<bool>& of_parts, double jitter,
                  Random& random, Bricks& bricks) const {
  const std::vector<bool> met = cells_met(task, sampler, of_parts);
  const bool all = std::find(met.begin(), met.end(), true) == met.end();  // too thin to meet any
  const auto along = static_cast<std::size_t>(along_), deep = 2 - along;
  std::array<std::vector<double>, 3> at;
  for (const std::size_t a : {along, std::size_t{1}, deep}) at[a] = coordinates(d_[a], jitter, random);
  Pacer pacer(task.execution);
  for (std::uint32_t w = 0; w < d_[deep].count; ++w)
    for (std::uint32_t row = 0; row < d_[1].count; ++row) {
      const std::uint32_t shift = (row + w) % split_;
      std::uint32_t last = 0xffffffffu;  // last brick of the course
      for (std::uint32_t k = 0; k < d_[along].count; ++k) {
        pacer.step();
        std::array<std::uint32_t, 3> cell{};
        cell[along] = k;
        cell[1] = row;
        cell[deep] = w;
        if (!all && !met[index(cell[0], cell[1], cell[2])]) continue;
        if (const std::uint32_t brick = (k + shift) / split_; brick != last) {
          last = brick;
          Vec3d middle, half;
          for (std::size_t a = 0; a < 3; ++a) {
            const double length = a == along ? split_ * d_[a].step : d_[a].step;
            const double begin = a == along ? brick * length - shift * d_[a].step : cell[a] * length;
            middle[static_cast<int>(a)] = d_[a].start + begin + 0.5 * length;
            half[static_cast<int>(a)] = 0.5 * length;
          }
          bricks.bricks.push_back({middle, half, static_cast<std::uint32_t>(bricks.cells.size())});
        }
        bricks.cells.push_back({at[0][cell[0]], at[1][cell[1]], at[2][cell[2]]});
      }
    }
}

}  // namespace fracture::sites_detail
