// What a request should cost before any of it is computed: for the queue's prediction and the memory budget.
#pragma once

#include <cstdint>

#include "common/parameters/parameters.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct ExpectedWork {
  /// Of one thread of the machine this was written on. WorkerPool measures how far off that is, so only the
  /// proportions matter.
  double seconds = 0;
  std::uint64_t bytes = 0;  ///< held at the peak
};

/// How many sites the parameters will lead to, every later one (a local hit, a limit of size, a fragment
/// fractured again) included; of each of the two at most FractureParameters::most_sites. Patterns whose cells have a given size,
/// and max_volume, are counted in the box and the volume of the `solid`; without one (nothing is known of the
/// mesh yet) they count as `sites`.
double expected_sites(const FractureParameters& parameters, const Solid* solid,
                      const Selection& selection = {});

/// Triangles of the rough cuts between so many cells, each counted once; 0 where cuts are flat.
double expected_rough_triangles(const FractureParameters& parameters, double sites);

/// Undoing a Content-Encoding; taking a body apart; reading an entry of a tier. Of the bytes that they make
/// or read. Their memory is reserved by whoever holds it.
ExpectedWork expected_decoding(std::uint64_t decoded_bytes);
ExpectedWork expected_reading(std::uint64_t bytes);
/// Of compressing an answer: the bound of what comes out, and the copy of what did.
ExpectedWork expected_coding(std::uint64_t plain_bytes);

/// `mesh_bytes`: still to be read and prepared, 0 when that is done and `solid` is given. `triangles`: of the
/// solid, where they were counted before.
ExpectedWork expected_work(const FractureParameters& parameters, std::uint64_t mesh_bytes, const Solid* solid,
                           std::uint64_t triangles = 0, const Selection& selection = {});
/// Further seconds. Walls (`shell`) are made when a mesh of so many bytes is prepared, 0 when that is done; the maps of
/// `interior_detail` are made for the first answer of a process that has them.
double expected_further_seconds(const RequestParameters& asked, std::uint64_t mesh_bytes);
/// Of the new hits alone, where the answer before them is kept and they are local (hits/delta.hpp).
ExpectedWork expected_hit_work(const FractureParameters& parameters, const Selection& selection,
                               const Solid* solid);
/// Of reading and preparing alone.
ExpectedWork expected_work(std::uint64_t mesh_bytes);

}  // namespace fracture
