#include "common/pipeline/cell_touches.hpp"

#include <numeric>

namespace fracture {

CellTouches::CellTouches(const RestrictedDiagram& d, Pacer& pacer) {
  struct Pair {
    SiteId lo, hi;
    double area;
  };
  std::vector<Pair> pairs;
  for (const CapRegion& r : d.caps.regions) {  // by (lo, hi, part)
    pacer.step(2 + 2 * r.triangle_count);
    double area = 0;
    for (std::uint32_t k = r.first_triangle; k < r.first_triangle + r.triangle_count; ++k) {
      const auto& v = d.caps.triangles[k];
      area += 0.5 * length(cross(d.point(v[1]) - d.point(v[0]), d.point(v[2]) - d.point(v[0])));
    }
    if (!pairs.empty() && pairs.back().lo == r.lo && pairs.back().hi == r.hi)
      pairs.back().area += area;
    else
      pairs.push_back({r.lo, r.hi, area});
  }
  std::erase_if(pairs, [](const Pair& p) { return !(p.area > 0); });
  begin_.assign(d.diagram.dual().site_count() + 2, 0);
  for (const Pair& p : pairs) {
    ++begin_[p.lo + 2];
    ++begin_[p.hi + 2];
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  all_.resize(2 * pairs.size());
  for (const Pair& p : pairs) {
    pacer.step(2);
    all_[begin_[p.lo + 1]++] = {p.hi, p.area};
    all_[begin_[p.hi + 1]++] = {p.lo, p.area};
  }
}

}  // namespace fracture
