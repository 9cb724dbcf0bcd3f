// Estimates what hits add to an answer. A hit cuts what is there, so its cells and the earlier pieces form an overlay, which has
// more pieces than both together.
#pragma once

#include <cstddef>

#include "common/pipeline/fracture.hpp"
#include "server/service/solid_figures.hpp"

namespace fracture {

struct HitNumbers {
  double sites = 0;                               ///< of all hits, including the cells of aggregates
  double fragments = 0;                           ///< more than without the hits
  double surface = 0;                             ///< more triangles of the outside
  double cut_triangles = 0, rough_triangles = 0;  ///< more triangles of cuts, on both sides
  double hulls = 0;                               ///< more than without the hits
  double kept_bytes = 0;                          ///< of memory for the new pieces
  double step_bytes = 0;                          ///< of memory for the largest hit while it is applied
};

/// Expects the effect of the hits from number `first` on. The hits before it count as pieces that are there.
/// `fragments`, `triangles`: of the answer without any hits. Linear in the parts, and quadratic in the hits, of which there are at most
/// 64. A solid without volume gives zeros.
///
/// The cells of a hit cut each small part by itself. The number of its pieces is the number of cells that meet it.
/// The number of pieces in an overlay of two independent sets of random cells is the number of pairs of cells that meet. It follows
/// from the mean volume, surface and width of a cell (Santaló 1976, Integral Geometry and Geometric Probability, III.15; the means of
/// Meijering 1953).
HitNumbers expected_of_hits(const FractureParameters& parameters, const SolidFigures& solid, double fragments,
                            double triangles, std::size_t first = 0);

}  // namespace fracture
