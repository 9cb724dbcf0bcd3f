// Polls inside loops whose steps are too cheap for one poll each, and inside sorts.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"

namespace fracture {

/// Counts steps of about a dozen to a thousand instructions, and polls once per few thousand steps.
class Pacer {
 public:
  explicit Pacer(const Execution& execution) : execution_(execution) {}
  /// `work`: the number of steps to count.
  void step(std::uint64_t work = 1) {
    done_ += work;
    if (done_ < kBetweenPolls) return;
    done_ = 0;
    execution_.poll();
  }
  /// Calls body(k) for k in [begin, end), one step each. For loops so tight that counting each step costs
  /// noticeable time.
  template <class Body>
  void each(std::size_t begin, std::size_t end, const Body& body) {
    while (begin < end) {
      const std::size_t stop = std::min(end, begin + kBetweenPolls / 8);
      step(stop - begin);
      for (; begin < stop; ++begin) body(begin);
    }
  }

 private:
  static constexpr std::uint64_t kBetweenPolls = 8192;
  const Execution& execution_;
  std::uint64_t done_ = 0;
};

/// Number of bytes to copy or compress between two polls.
inline constexpr std::size_t kBytesBetweenPolls = std::size_t{1} << 18;

/// std::sort that can be interrupted, for arrays that may have more than some ten thousand elements (a
/// million take a tenth of a second). Elements must be trivially copyable, so that an interruption loses only
/// their order.
template <class Iterator, class Less>
void sort_with_polls(const Execution& execution, Iterator first, Iterator last, const Less& less) {
  if (last - first < 4096) return std::sort(first, last, less);  // less than a millisecond
  Pacer pacer(execution);
  std::sort(first, last, [&](const auto& a, const auto& b) {
    pacer.step();
    return less(a, b);
  });
}
template <class Iterator>
void sort_with_polls(const Execution& execution, Iterator first, Iterator last) {
  sort_with_polls(execution, first, last, [](const auto& a, const auto& b) { return a < b; });
}

/// vector.resize(size) that can be interrupted: a gigabyte of fresh memory takes a fifth of a second.
template <class T>
void resize_with_polls(const Execution& execution, std::vector<T>& vector, std::size_t size) {
  constexpr std::size_t kAtOnce = (std::size_t{4} << 20) / sizeof(T);
  vector.reserve(size);
  while (vector.size() + kAtOnce < size) {
    vector.resize(vector.size() + kAtOnce);
    execution.poll();
  }
  vector.resize(size);
}

/// Calls body(piece) for consecutive pieces of the bytes, with a poll before each.
template <class Byte, class Body>
void each_piece(const Execution& execution, std::span<const Byte> bytes, const Body& body) {
  static_assert(sizeof(Byte) == 1);
  while (!bytes.empty()) {
    execution.poll();
    const auto piece = bytes.first(std::min(bytes.size(), kBytesBetweenPolls));
    body(piece);
    bytes = bytes.subspan(piece.size());
  }
}

/// std::all_of that can be interrupted.
template <class T, class Good>
bool all_of_with_polls(const Execution& execution, const std::vector<T>& values, const Good& good) {
  constexpr std::size_t kAtOnce = kBytesBetweenPolls / sizeof(T);
  for (std::size_t begin = 0; begin < values.size(); begin += kAtOnce) {
    execution.poll();
    const auto block = std::span(values).subspan(begin, std::min(values.size() - begin, kAtOnce));
    if (!std::all_of(block.begin(), block.end(), good)) return false;
  }
  return true;
}

/// Adds bytes to the end of a vector that has room for them. Can be interrupted.
template <class Byte>
void append_with_polls(const Execution& execution, std::vector<Byte>& vector, std::span<const Byte> bytes) {
  each_piece(execution, bytes, [&vector](std::span<const Byte> piece) {
    vector.insert(vector.end(), piece.begin(), piece.end());
  });
}

/// Destroys elements that own memory, one by one; a million take a tenth of a second.
template <class T>
void clear_with_polls(const Execution& execution, std::vector<T>& vector) {
  Pacer pacer(execution);
  for (; !vector.empty(); vector.pop_back()) pacer.step(8);
}

/// Destroys the nodes of a map or set one by one. One step of the pacer represents about 10 ns.
template <class Nodes>
void clear_nodes(Pacer& pacer, Nodes& nodes) {
  for (; !nodes.empty(); nodes.erase(nodes.begin())) pacer.step(8);
}

}  // namespace fracture
