// The steps of tetrahedralize(), for every insertion algorithm: selecting the sites, inserting them in a good
// order, and numbering the result.
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
  std::size_t given = 0;             ///< number in the caller's list
  std::vector<std::uint32_t> input;  ///< index of each kept site in that list
  std::vector<Vec3d> points;
  Box domain;                  ///< U: the box and the kept sites
  std::uint32_t max_tets = 0;  ///< limit; more are refused
};

/// Errors: kNotFinite and kTooComplex, as for tetrahedralize().
Expected<KeptSites> keep_sites(std::span<const Vec3d> sites, const Box& box);

/// Returns the result after every kept point has become a vertex (`vertex_of`, per point). Consumes
/// `delaunay`.
Tetrahedralization numbered(IncrementalDelaunay& delaunay, const KeptSites& sites,
                            const std::vector<TetVertexId>& vertex_of);

/// How many insertions ahead coordinates are prefetched, because the order of insertion accesses the caller's
/// list in scattered order.
inline constexpr std::size_t kPrefetch = 8;

/// Inserts every site with insert(p) into `delaunay`, which must be empty and have the domain sites.domain,
/// and is consumed. Error: kTooComplex. Throws Interrupted.
template <class Insert>
Expected<Tetrahedralization> insert_all(IncrementalDelaunay& delaunay, const KeptSites& sites,
                                        const Execution& execution, const Insert& insert) {
  using Status = IncrementalDelaunay::Status;
  const std::vector<Vec3d>& points = sites.points;
  std::uint32_t counted = 0;
  if (IncrementalDelaunay::reserves_much(points.size())) {  // then the memory is held from here on
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
