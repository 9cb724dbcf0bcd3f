#include "common/rough/surface_grid.hpp"

#include <algorithm>

namespace fracture {
namespace {

constexpr double kMostCells = 1 << 20;

}  // namespace

double distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a, ac = c - a, ap = p - a;
  const auto to = [&](const Vec3d& q) { return length(p - q); };
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return to(a);
  const Vec3d bp = p - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return to(b);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 - d3 > 0) return to(a + (d1 / (d1 - d3)) * ab);
  const Vec3d cp = p - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return to(c);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 - d6 > 0) return to(a + (d2 / (d2 - d6)) * ac);
  const double va = d3 * d6 - d5 * d4;
  const double on_bc = d4 - d3, beyond = d5 - d6;
  if (va <= 0 && on_bc >= 0 && beyond >= 0 && on_bc + beyond > 0)
    return to(b + (on_bc / (on_bc + beyond)) * (c - b));
  const double sum = va + vb + vc;
  if (!(sum > 0)) return std::min({to(a), to(b), to(c)});  // flat
  return to(a + (vb / sum) * ab + (vc / sum) * ac);
}

UniformGrid::UniformGrid(const Box& box, double least_width) : origin_(box.min), width_(least_width) {
  const Vec3d size = box.size();
  const auto cells = [&](int a) { return std::floor(size[a] / width_) + 1; };
  while (cells(0) * cells(1) * cells(2) > kMostCells) width_ *= 1.25;
  for (int a = 0; a < 3; ++a) count_[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(cells(a));
}

SurfaceGrid::SurfaceGrid(const Solid& solid, double reach)
    : solid_(solid), reach_(reach), grid_(solid.box, 0.5 * reach), begin_(grid_.size() + 1, 0) {
  // The cells of a triangle's box that its plane may meet: |distance of the middle| <= half the diagonal.
  const double margin = 0.8661 * grid_.width();
  const auto each = [&](const auto& visit) {
    for (std::uint32_t t = 0; t < solid_.triangles.size(); ++t) {
      const auto [a, b, c] = corners(t);
      Box box;
      for (const Vec3d& p : {a, b, c}) box.add(p);
      const Vec3d normal = cross(b - a, c - a);
      const double most = margin * length(normal) + 1e-12 * dot(box.size(), box.size()) * length(box.size());
      grid_.each_cell(box.min, box.max, [&](const UniformGrid::Cell& cell) {
        if (std::fabs(dot(normal, grid_.middle(cell) - a)) <= most) visit(grid_.index(cell), t);
      });
    }
  };
  each([&](std::size_t cell, std::uint32_t) { ++begin_[cell + 1]; });
  for (std::size_t c = 0; c < grid_.size(); ++c) begin_[c + 1] += begin_[c];
  triangles_.resize(begin_.back());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  each([&](std::size_t cell, std::uint32_t t) { triangles_[next[cell]++] = t; });

  nearby_.assign(grid_.size(), false);
  const Vec3d around{reach, reach, reach};
  const Vec3d half = (0.5 * grid_.width()) * Vec3d{1, 1, 1};
  const UniformGrid::Cell last = grid_.cell_of(solid.box.max);
  for (std::int64_t z = 0; z <= last[2]; ++z)
    for (std::int64_t y = 0; y <= last[1]; ++y)
      for (std::int64_t x = 0; x <= last[0]; ++x) {
        const UniformGrid::Cell cell{x, y, z};
        if (begin_[grid_.index(cell)] == begin_[grid_.index(cell) + 1]) continue;
        const Vec3d middle = grid_.middle(cell);
        grid_.each_cell(middle - half - around, middle + half + around,
                        [&](const UniformGrid::Cell& near) { nearby_[grid_.index(near)] = true; });
      }
}

double SurfaceGrid::distance(const Vec3d& p) const {
  const UniformGrid::Cell home = grid_.cell_of(p);
  if (!nearby_[grid_.index(home)]) return reach_;
  double least = reach_;
  const auto look = [&](const UniformGrid::Cell& cell) {
    const std::size_t c = grid_.index(cell);
    for (std::uint32_t k = begin_[c]; k < begin_[c + 1]; ++k) {
      const auto [q, r, s] = corners(triangles_[k]);
      // Cheaper than the distance: that to the plane, where it is too far already.
      const Vec3d n = cross(r - q, s - q);
      const double d = dot(n, p - q);
      if (d * d > least * least * dot(n, n)) continue;
      least = std::min(least, distance_to_triangle(p, q, r, s));
    }
  };
  look(home);  // first, so that the others can be skipped
  const Vec3d around{least, least, least};
  grid_.each_cell(p - around, p + around, [&](const UniformGrid::Cell& cell) {
    if (cell == home) return;
    double square = 0;  // of the distance from p to the cell
    const Vec3d middle = grid_.middle(cell);
    for (int a = 0; a < 3; ++a) {
      const double beyond = std::fmax(std::fabs(p[a] - middle[a]) - 0.50001 * grid_.width(), 0);
      square += beyond * beyond;
    }
    if (square < least * least) look(cell);
  });
  return least;
}

}  // namespace fracture
