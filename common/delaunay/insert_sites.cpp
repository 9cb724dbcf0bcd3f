// Further sites in a tetrahedralization that is kept: a hit on what is fractured already.
#include <algorithm>
#include <vector>

#include "common/delaunay/incremental.hpp"
#include "common/delaunay/spatial_order.hpp"
#include "common/delaunay/tetrahedralization.hpp"

namespace fracture {

std::optional<Tetrahedralization> insert_sites(const Tetrahedralization& before,
                                               std::span<const Vec3d> further, const Box& box,
                                               const Execution& execution) {
  const std::uint32_t sites = before.site_count();
  const std::size_t given = before.site_of_input.size() + further.size();
  if (box.empty() || before.far_sites_dropped > 0 || given > kMaxSites) return std::nullopt;
  const BigTetrahedron big = big_tetrahedron(box);
  const auto inside = [&](const Vec3d& p) { return big.contains(p); };
  if (!std::all_of(before.points.begin(), before.points.end() - 4, inside) ||
      !std::all_of(further.begin(), further.end(), inside))
    return std::nullopt;

  const auto limit = static_cast<std::uint32_t>(
      std::min<std::uint64_t>(kTetsAlways + kTetsPerSite * static_cast<std::uint64_t>(given), 0x3ffffff0u));
  IncrementalDelaunay delaunay(big, {limit, &execution}, before);
  // For each further point the vertex it became; for each vertex the lowest further point that it stands for.
  std::vector<TetVertexId> vertex_of(further.size());
  std::vector<std::size_t> first_of(4 + sites + further.size(), further.size());
  const std::vector<std::uint32_t> order = spatial_order(further, execution);
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k % 64 == 0) execution.poll();
    const auto [status, vertex] = delaunay.insert(further[order[k]]);
    if (status == IncrementalDelaunay::Status::kFull) return std::nullopt;
    if (status == IncrementalDelaunay::Status::kOutsideDomain)
      throw InternalError("a site outside its own domain");
    vertex_of[order[k]] = vertex;
    first_of[vertex] = std::min<std::size_t>(first_of[vertex], order[k]);
  }

  execution.made(Product::kTetrahedra, delaunay.tet_count());  // a copy

  std::vector<SiteId> site_of_vertex(delaunay.vertex_end(), kNoSite);
  for (const SiteId s : ids<SiteId>(sites)) site_of_vertex[4 + s] = s;
  SiteId next{sites};
  for (std::size_t k = 0; k < further.size(); ++k)
    if (vertex_of[k] >= 4 + sites && first_of[vertex_of[k]] == k) site_of_vertex[vertex_of[k]] = next++;
  Tetrahedralization result = delaunay.snapshot(site_of_vertex);
  result.site_of_input = before.site_of_input;
  for (const TetVertexId v : vertex_of) result.site_of_input.push_back(site_of_vertex[v]);
  result.duplicates_merged =
      before.duplicates_merged + static_cast<std::uint32_t>(further.size()) - (next - sites);
  canonicalize(result, execution);
  return result;
}

}  // namespace fracture
