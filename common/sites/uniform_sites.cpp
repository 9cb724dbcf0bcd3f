#include "common/sites/column_sampler.hpp"
#include "common/sites/sites.hpp"

namespace fracture {

Expected<std::vector<Vec3d>> uniform_sites(const Solid& solid, std::uint32_t count, std::uint64_t seed,
                                           const Execution& execution) {
  if (count == 0) return std::vector<Vec3d>{};
  std::vector<Vec3d> sites = sites_detail::ColumnSampler(solid, seed, execution).sample(count);
  const SiteLattice lattice = site_lattice(solid.box);
  for (Vec3d& site : sites) site = lattice.snap(site);
  return sites;
}

}  // namespace fracture
