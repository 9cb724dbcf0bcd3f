// The steps of tetrahedralize(), for every way to insert a site: which sites count, their insertion in a good
// order, and the numbering of the result.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/delaunay/incremental.hpp"
#include "common/delaunay/spatial_order.hpp"

namespace fracture::delaunay_detail {

/// The sites that may own a point of the box.
struct KeptSites {
  std::size_t given = 0;             ///< in the caller's list
  std::vector<std::uint32_t> input;  ///< where each stands in it
  std::vector<Vec3d> points;
  Box domain;                  ///< U: the box and the kept sites
  std::uint32_t max_tets = 0;  ///< more are refused
};

/// Errors: kNotFinite, kTooComplex, as tetrahedralize() says.
Expected<KeptSites> keep_sites(std::span<const Vec3d> sites, const Box& box);

/// The result, once every kept point has become a vertex (`vertex_of`, per point). Uses `delaunay` up.
Tetrahedralization numbered(IncrementalDelaunay& delaunay, const KeptSites& sites,
                            const std::vector<TetVertexId>& vertex_of);

/// How many insertions ahead the coordinates are fetched: the order of insertion jumps about in the caller's
/// list.
inline constexpr std::size_t kPrefetch = 8;

/// Has insert(p) put every site into `delaunay`, which is empty and has sites.domain, and is used up. Error:
/// kTooComplex. Throws Interrupted.
template <class Insert>
Expected<Tetrahedralization> insert_all(IncrementalDelaunay& delaunay, const KeptSites& sites,
                                        const Execution& execution, const Insert& insert) {
  using Status = IncrementalDelaunay::Status;
  const std::vector<Vec3d>& points = sites.points;
  std::uint32_t counted = 0;
  if (IncrementalDelaunay::reserves_much(points.size())) {  // then it is held from here on
    counted = static_cast<std::uint32_t>(IncrementalDelaunay::reserved_tets(points.size()) *
                                         IncrementalDelaunay::kTetBytes / bytes_of(Product::kTetrahedra));
    execution.made(Product::kTetrahedra, counted);
  }
  delaunay.reserve(points.size());
  const std::vector<std::uint32_t> order = spatial_order(points, execution);
  std::vector<TetVertexId> vertex_of(points.size());
  const auto count_new = [&] {
    if (delaunay.tet_count() <= counted) return;
    execution.made(Product::kTetrahedra, delaunay.tet_count() - counted);
    counted = delaunay.tet_count();
  };
  StageProgress::Loop progress(execution.within, (order.size() + 63) / 64);
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i % 64 == 0) {
      execution.poll();
      progress.at(i / 64);
      count_new();
    }
    if (i + kPrefetch < order.size()) __builtin_prefetch(&points[order[i + kPrefetch]]);
    const auto [status, vertex] = insert(points[order[i]]);
    if (status == Status::kFull)
      return fail(ErrorCode::kTooComplex,
                  "The Delaunay tetrahedralization of these sites has more than " +
                      std::to_string(sites.max_tets) +
                      " tetrahedra (n points on two skew lines produce n^2/4 tetrahedra).",
                  "/points", {{"limit", sites.max_tets}});
    if (status == Status::kOutsideDomain) throw InternalError("a site outside its own domain");
    vertex_of[order[i]] = vertex;
  }
  count_new();
  return numbered(delaunay, sites, vertex_of);
}

}  // namespace fracture::delaunay_detail
