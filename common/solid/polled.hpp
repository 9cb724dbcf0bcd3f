// Loops and arrays of millions of elements, processed in blocks, with a poll between blocks.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

#include "common/base/disjoint_sets.hpp"
#include "common/base/execution.hpp"

namespace fracture::solid_detail {

/// Calls body(i) for every i in [0, count). For bodies with up to a few random memory accesses (some 100 ns
/// each), so that a block takes a few milliseconds at most.
template <class Body>
void for_each_polled(const Execution& execution, std::size_t count, Body&& body) {
  constexpr std::size_t kBlock = 16384;
  StageProgress::Loop progress(execution.within, (count + kBlock - 1) / kBlock);
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    execution.poll();
    progress.at(begin / kBlock);
    const std::size_t end = std::min(count, begin + kBlock);
    for (std::size_t i = begin; i < end; ++i) body(i);
  }
}

/// Returns a vector of `count` copies of `value`. Fresh memory takes about a millisecond per 2 MB.
template <class T>
std::vector<T> filled(const Execution& execution, std::size_t count, const T& value) {
  constexpr std::size_t kStep = (std::size_t{4} << 20) / sizeof(T);
  std::vector<T> items;
  items.reserve(count);
  for (std::size_t size = 0; size < count;) {
    execution.poll();
    size = std::min(count, size + kStep);
    items.resize(size, value);
  }
  return items;
}

/// Returns a copy of the vector, with room for `more` further elements.
template <class T>
std::vector<T> copied(const Execution& execution, const std::vector<T>& from, std::size_t more = 0) {
  constexpr std::size_t kStep = (std::size_t{4} << 20) / sizeof(T);
  std::vector<T> items;
  items.reserve(from.size() + more);
  for (std::size_t begin = 0; begin < from.size(); begin = items.size()) {
    execution.poll();
    const std::size_t end = std::min(from.size(), begin + kStep);
    items.insert(items.end(), from.data() + begin, from.data() + end);
  }
  return items;
}

/// Makes room before elements are added one by one. If the vector would have to copy all its elements to a
/// larger block, they are copied with polls.
template <class T>
void make_room(const Execution& execution, std::vector<T>& items, std::size_t more = 1) {
  if (items.capacity() - items.size() >= more) return;
  items = copied(execution, items, std::max(more, items.size()));
}

/// Calls the functions, which must be independent, each on its own thread if one is free. `triangles`: size
/// of their work; if it is small, no other thread is woken.
template <class... Functions>
void side_by_side(const Execution& execution, std::size_t triangles, const Functions&... functions) {
  constexpr std::size_t kCount = sizeof...(Functions), kFew = 32768;  // about 0.3 ms each
  const std::function<void()> each[] = {std::cref(functions)...};
  parallel_for(execution, kCount, triangles < kFew ? kCount : 1, [&](std::size_t begin, std::size_t end) {
    for (; begin < end; ++begin) each[begin]();
  });
}

/// Returns `count` sets with one member each.
inline DisjointSets singletons(const Execution& execution, std::size_t count) {
  DisjointSets sets;
  sets.reserve(count);
  for_each_polled(execution, count, [&](std::size_t) { sets.add(); });
  return sets;
}

}  // namespace fracture::solid_detail
