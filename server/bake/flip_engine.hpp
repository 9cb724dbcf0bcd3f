// --insertion flips: uses the source paper's insertion method instead of ours. The output bytes are the same.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "common/delaunay/reference/reference_delaunay.hpp"
#include "server/service/engine.hpp"

namespace fracture::bake {

/// Counts the flips of all jobs of a bake. Thread-safe.
class FlipTally {
 public:
  void add(const FlipCounts& more) {
    const std::lock_guard lock(mutex_);
    counts_ += more;
  }
  FlipCounts counts() const {
    const std::lock_guard lock(mutex_);
    return counts_;
  }
  /// Returns "inserted by flips: 38 flip14, 2 flip26, 0 flip n-2n; 411 flip23, 329 flip32, 17 flip44"
  std::string sentence() const;

 private:
  mutable std::mutex mutex_;
  FlipCounts counts_;
};

/// Wraps `inner`. Once the sites of a diagram are placed, they are tetrahedralized again by flips, and the
/// cells are cut from that result. The sites themselves are still placed with cavity insertion: Lloyd's
/// relaxation and max_volume measure cells, and the last bits of these measurements depend on the order of
/// the tetrahedra.
std::unique_ptr<FractureEngine> flip_engine(std::unique_ptr<FractureEngine> inner,
                                            std::shared_ptr<FlipTally> tally);

}  // namespace fracture::bake
