#include "common/delaunay/insert_all.hpp"
#include "common/delaunay/reference/reference_delaunay.hpp"

namespace fracture {

Expected<Tetrahedralization> tetrahedralize_by_flips(std::span<const Vec3d> sites, const Box& box,
                                                     const Execution& execution, FlipCounts* counts) {
  const Expected<delaunay_detail::KeptSites> kept = delaunay_detail::keep_sites(sites, box);
  if (!kept) return tl::unexpected(kept.error());
  ReferenceDelaunay delaunay(big_tetrahedron(kept->domain), {kept->max_tets, &execution});
  Expected<Tetrahedralization> result = delaunay_detail::insert_all(
      delaunay, *kept, execution, [&](const Vec3d& p) { return delaunay.insert_by_flips(p); });
  if (counts) *counts += delaunay.flips();
  return result;
}

}  // namespace fracture
