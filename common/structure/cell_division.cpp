#include "common/structure/cell_division.hpp"

#include <algorithm>
#include <cmath>

namespace fracture {
namespace {

double square(const Vec3d& v) { return dot(v, v); }

}  // namespace

CellDivision::CellDivision(const FragmentsOfCells& table, std::span<const Vec3d> points, bool has_many)
    : table_(table), points_(points) {
  if (has_many) tree_.emplace(points);
}

void CellDivision::near_of(const NearCells& among, const CellBox& box, SomeCells& some) {
  some.places.clear();
  const std::size_t size = among.size();
  if (size == 0) return;  // the part has no cell near the box
  constexpr std::size_t kAtOnce = 64;
  std::array<double, kAtOnce> few;
  std::vector<double> many(size > kAtOnce ? size : 0);
  double* const squares = size > kAtOnce ? many.data() : few.data();  // squared distances from the middle
  const Vec3d* const points = among.points.data();
  const Vec3d center = box.center;
  double least = HUGE_VAL;
  std::size_t nearest = 0;
  for (std::size_t k = 0; k < size; ++k) {
    const double d2 = square(points[k] - center);
    squares[k] = d2;
    if (d2 < least) {
      least = d2;
      nearest = k;
    }
  }
  some.nearest = static_cast<std::uint32_t>(nearest);
  // If a site is nearest to some point of the box, two conditions hold. Its distance from the middle
  // exceeds the smallest distance by at most twice the radius, and the box reaches beyond the bisector of
  // the two sites.
  const double far = (std::sqrt(least) + 2 * length(box.half)) * (1 + 1e-9), far2 = far * far;
  const Vec3d reach = (2 * (1 + 1e-9)) * box.half, own = points[nearest];
  for (std::size_t k = 0; k < size; ++k) {
    if (squares[k] > far2) continue;
    const double over = squares[k] - least;  // the bisector's distance, times twice that of the sites
    const Vec3d u = points[k] - own;
    if (over <= std::fabs(u.x) * reach.x + std::fabs(u.y) * reach.y + std::fabs(u.z) * reach.z)
      some.places.push_back(static_cast<std::uint32_t>(k));
  }
}

void CellDivision::near_of(const NearCells& among, const CellBox& box, Scratch& scratch, NearCells& cells) {
  near_of(among, box, scratch.some);
  cells.clear();
  for (const std::uint32_t k : scratch.some.places)
    cells.push(among.cells[k], among.sites[k], among.points[k]);
}

void CellDivision::near(std::uint32_t part, const CellBox& box, Scratch& scratch, NearCells& cells) const {
  const FragmentsOfCells::Cells all = table_.of(part);
  NearCells& among = scratch.among;
  among.clear();
  const auto add = [&](std::uint32_t cell) {
    const SiteId site = table_.site(cell);
    among.push(cell, site, points_[site]);
  };
  if (!tree_ || all.size() <= kMany) {
    for (std::uint32_t cell = all.begin; cell < all.end; ++cell) add(cell);
    return near_of(among, box, scratch, cells);
  }
  double least = HUGE_VAL;
  tree_->visit_near(box.center, least, [&](std::uint32_t, double d2) { return least = std::min(least, d2); });
  const double radius = (std::sqrt(least) + 2 * length(box.half)) * (1 + 1e-9);
  std::vector<std::uint32_t> found;
  tree_->visit_near(box.center, radius * radius, [&](std::uint32_t s, double) {
    if (const std::uint32_t cell = table_.find(part, SiteId{s}); cell != kNoIndex) found.push_back(cell);
    return radius * radius;
  });
  std::sort(found.begin(), found.end());
  for (const std::uint32_t cell : found) add(cell);
  near_of(among, box, scratch, cells);
}

/// Keeps the part of the polygon that is nearer to one site than to the other. Computed from either side,
/// heights over the bisector have the same bits.
bool CellDivision::cut(CellPolygon& polygon, SiteId keep, const Vec3d& keep_point, SiteId other,
                       const Vec3d& other_point) {
  const Vec3d &low = keep < other ? keep_point : other_point, &high = keep < other ? other_point : keep_point;
  const Vec3d across = high - low, middle = 0.5 * (low + high);
  std::array<double, CellPolygon::kMost> heights;
  bool is_cut = false, is_kept = false;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const double h = dot(across, polygon.corner(k) - middle);
    heights[k] = keep < other ? -h : h;
    is_cut |= heights[k] < 0;
    is_kept |= heights[k] > 0;
  }
  if (!is_cut) return false;
  if (!is_kept) {
    polygon.clear();
    return true;
  }
  CellPolygon kept;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const std::size_t next = k + 1 < polygon.size() ? k + 1 : 0;
    const double here = heights[k], there = heights[next];
    if (here < 0 && there < 0) continue;
    const Vec3d p = polygon.corner(k), q = polygon.corner(next);
    if (here >= 0) {
      kept.push(p, polygon.beyond(k));
      if (there < 0) kept.push(p + (here / (here - there)) * (q - p), other);
    } else {
      kept.push(q + (there / (there - here)) * (p - q), polygon.beyond(k));
    }
  }
  if (kept.size() < 3) kept.clear();
  polygon = kept;
  return true;
}

bool CellDivision::region(std::uint32_t place, const NearCells& near, std::span<const std::uint32_t> some,
                          const CellPolygon& whole, CellPolygon& region) const {
  const SiteId site = near.sites[place];
  region = whole;
  std::size_t cuts = 0;
  bool is_in_order = false;
  if (tree_ && some.size() > kMany) {
    // Sites that bound the region are at most twice as far away as its farthest corner (Lévy & Bonneel
    // 2012, "Variational anisotropic surface meshing with Voronoi parallel linear enumeration").
    const Vec3d& p = points_[site];
    const auto reach2 = [&] {
      double farthest = 0;
      for (std::size_t k = 0; k < region.size(); ++k)
        farthest = std::max(farthest, square(region.corner(k) - p));
      return 4 * farthest * (1 + 1e-9);
    };
    double radius2 = reach2();
    tree_->visit_near(p, radius2, [&](std::uint32_t s, double) {
      if (s != site && cut(region, site, SiteId{s})) {
        ++cuts;
        radius2 = reach2();
      }
      return radius2;
    });
  } else {
    is_in_order = true;
    for (const std::uint32_t other : some) {
      if (other == place) continue;
      cuts += cut(region, site, near.points[place], near.sites[other], near.points[other]) ? 1 : 0;
      if (region.size() == 0) break;
    }
  }
  if (cuts == 0 || region.size() == 0) return cuts > 0;
  if (is_in_order && cuts == 1) return true;
  std::array<SiteId, CellPolygon::kMost> bounds;  // the sites that bound the region, in order
  auto end = bounds.begin();
  for (std::size_t k = 0; k < region.size(); ++k)
    if (region.beyond(k) != kNoSite) *end++ = region.beyond(k);
  std::sort(bounds.begin(), end);
  end = std::unique(bounds.begin(), end);
  if (is_in_order && static_cast<std::size_t>(end - bounds.begin()) == cuts) return true;
  region = whole;
  for (auto s = bounds.begin(); s != end; ++s) cut(region, site, *s);
  return true;
}

}  // namespace fracture
