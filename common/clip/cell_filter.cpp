#include "common/clip/cell_filter.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"

namespace fracture {

// Let u be the neighbour minus the site and d the point minus the site, both rounded to floats. The error of
// |u|²/2 - u . d is less than eight roundings of 2^-24, each of at most |u|²/2 + |u_x d_x| + |u_y d_y| + |u_z
// d_z|. Twice that much is subtracted here. 1e-30 exceeds the loss from underflow.
CellFilter::CellFilter(const VoronoiDiagram& diagram, const Box& box, const Execution& execution)
    : diagram_(diagram) {
  constexpr Bisectors kNone{Four{}, Four{}, Four{}, Four{1, 1, 1, 1}};  // nothing is beyond these
  constexpr double kRounding = 0x1.0p-20;
  const double side = box.longest_side();
  if (side > 1e-100 && side < 1e100) scale_ = 1 / side;
  Pacer pacer(execution);
  const std::uint32_t sites = diagram.dual().site_count();
  begin_.assign(sites + 1, 0);
  for (std::uint32_t i = 0; i < sites; ++i) {
    const auto all = diagram.bisectors(SiteId{i});
    if (!diagram.has_many_neighbors(SiteId{i})) {
      const Vec3d low = diagram.site(SiteId{i}) - box.min, high = box.max - diagram.site(SiteId{i});
      const auto reach = [&](int a) { return scale_ * std::max(std::fabs(low[a]), std::fabs(high[a])); };
      for (std::size_t k = 0; k < all.size(); ++k) {
        if (k % 4 == 0) bisectors_.push_back(kNone);
        const Vec3d u = scale_ * all[k].u;
        const double off = std::fabs(u.x) * reach(0) + std::fabs(u.y) * reach(1) + std::fabs(u.z) * reach(2);
        Bisectors& four = bisectors_.back();
        four.x[k % 4] = static_cast<float>(u.x);
        four.y[k % 4] = static_cast<float>(u.y);
        four.z[k % 4] = static_cast<float>(u.z);
        four.half[k % 4] = static_cast<float>((1 - kRounding) * 0.5 * dot(u, u) - kRounding * off - 1e-30);
      }
      pacer.step(all.size());
    }
    begin_[i + 1] = static_cast<std::uint32_t>(bisectors_.size());
  }
}

}  // namespace fracture
