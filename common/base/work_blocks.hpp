// Blocks of about equal work, for parallel loops over elements with very different costs.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/pacer.hpp"

namespace fracture {

/// Consecutive blocks that cover [0, size): block b is [begin[b], begin[b + 1]). Each block has at most
/// `most` work, or a single element. Depends only on the elements, not on the number of threads.
struct WorkBlocks {
  std::vector<std::size_t> begin{0};

  /// `work(k)`: the cost of element k, in nanoseconds, roughly.
  template <class Work>
  WorkBlocks(const Execution& execution, std::size_t size, std::uint64_t most, const Work& work) {
    Pacer pacer(execution);
    std::uint64_t sum = 0;
    for (std::size_t k = 0; k < size; ++k) {
      pacer.step();
      const std::uint64_t more = work(k);
      if (sum > 0 && sum + more > most) {
        begin.push_back(k);
        sum = 0;
      }
      sum += more;
    }
    if (size > 0) begin.push_back(size);
  }
  std::size_t count() const { return begin.size() - 1; }
};

/// Calls body(block, begin, end) for each block, on the threads of the execution.
template <class Body>
void parallel_for_blocks(const Execution& execution, const WorkBlocks& blocks, const Body& body) {
  parallel_for(execution, blocks.count(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t b = first; b < last; ++b) body(b, blocks.begin[b], blocks.begin[b + 1]);
  });
}

}  // namespace fracture
