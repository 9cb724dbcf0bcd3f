// --insertion flips: the source paper's insertion instead of ours, to the same bytes.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "common/delaunay/reference/reference_delaunay.hpp"
#include "server/service/engine.hpp"

namespace fracture::bake {

/// What all jobs of a bake flipped. Thread-safe.
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
  /// "inserted by flips: 38 flip14, 2 flip26, 0 flip n-2n; 411 flip23, 329 flip32, 17 flip44"
  std::string sentence() const;

 private:
  mutable std::mutex mutex_;
  FlipCounts counts_;
};

/// What `inner` does, but the sites of every diagram, once they are placed, are tetrahedralized by flips, and
/// that is cut. Where sites lie is decided before, with the cavity: Lloyd's relaxation and max_volume
/// measure cells, and what they measure depends in the last bit on the order of the tetrahedra.
std::unique_ptr<FractureEngine> flip_engine(std::unique_ptr<FractureEngine> inner,
                                            std::shared_ptr<FlipTally> tally);

}  // namespace fracture::bake
