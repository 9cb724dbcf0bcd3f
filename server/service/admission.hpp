// Estimates what a request will cost before any of it is computed. The queue's predictions and the memory budget use
// these estimates.
#pragma once

#include <cstdint>

#include "common/parameters/parameters.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

class SolidFigures;

struct ExpectedWork {
  /// Seconds on one thread of a reference machine. WorkerPool measures how far off that is, so only the
  /// proportions matter.
  double seconds = 0;
  std::uint64_t bytes = 0;  ///< peak memory
};

/// Returns how many sites the parameters will lead to. Sites of hits, and those added later by size limits or the refracture of
/// one fragment, are included. If hits leave the rest whole, the pattern adds no sites. The first fracture and the refracture count at most FractureParameters::most_sites each.
/// For patterns with a given cell size, and for max_volume, the number follows from the box and the volume of `solid`.
/// Without a solid, when nothing is known about the mesh yet, `sites` is used instead.
double expected_sites(const FractureParameters& parameters, const Solid* solid,
                      const Selection& selection = {});

/// Cuts between aggregates are ragged: their area is this many times that of the cuts between the same number of plain
/// cells.
inline constexpr double kRaggedness = 1.6;

/// Returns the number of triangles in the rough cuts between `sites` cells. Each cut counts once, although two cells share
/// it. Returns 0 if cuts are flat.
double expected_rough_triangles(const FractureParameters& parameters, double sites);

/// Returns the work of undoing a Content-Encoding. The result's `bytes` is 0, because the caller reserves the memory itself.
ExpectedWork expected_decoding(std::uint64_t decoded_bytes);
/// Returns the work of splitting a body into its parts, or of reading an entry from a cache tier. The caller reserves the
/// memory itself.
ExpectedWork expected_reading(std::uint64_t bytes);
/// Returns the work of compressing an answer. Its memory is a buffer for the largest possible output, and a copy of the
/// actual output.
ExpectedWork expected_coding(std::uint64_t plain_bytes);

/// Returns the work of a whole request. `mesh_bytes`: bytes that are still to be read and prepared; 0 if that is done and
/// `solid` is given. `triangles`: the number of the solid's triangles, if it is known from an earlier request. `figures`: of
/// `solid`, if other estimates share them. Throws Interrupted, as their execution says.
ExpectedWork expected_work(const FractureParameters& parameters, std::uint64_t mesh_bytes, const Solid* solid,
                           std::uint64_t triangles = 0, const Selection& selection = {},
                           const SolidFigures* figures = nullptr);
/// Returns further seconds, for walls and detail maps. Walls (`shell`) are made when a mesh is prepared; `mesh_bytes` is 0 if
/// that is done. The maps of `interior_detail` are made once in each process, for the first answer that uses them.
double expected_further_seconds(const RequestParameters& asked, std::uint64_t mesh_bytes);
/// Returns the work of only the new hits. Use it if the answer before them is kept (hits/delta.hpp).
ExpectedWork expected_hit_work(const FractureParameters& parameters, const Selection& selection,
                               const Solid* solid, const SolidFigures* figures = nullptr);
/// Returns the work of only reading and preparing a mesh.
ExpectedWork expected_work(std::uint64_t mesh_bytes);

/// Estimates the processor time of an estimate, s, which looks at each pair of a part and a hit. `evaluations`: how often it determines
/// the memory of a request.
double seconds_of_estimate(const FractureParameters& parameters, const Solid& solid, int evaluations);
/// Evaluations for a request that fits: fits(), expected_work() and expected_hit_work() with the same SolidFigures.
inline constexpr int kEvaluationsIfItFits = 4;
/// For estimate_document() and cannot_fit(), which search for the largest counts that fit.
inline constexpr int kEvaluationsWithAdvice = 45;
/// An io thread makes estimates that should take at most this long, s. Longer ones are made by the pool.
inline constexpr double kEstimateInline = 0.1e-3;

}  // namespace fracture
