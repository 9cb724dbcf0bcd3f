// Some elements of a list, in another order.
#pragma once

#include <cstdint>
#include <vector>

namespace fracture {

/// values[k] for each k of `of`; nothing of an empty list (an attribute that is not there). `each` is called
/// for every element: where callers let others go first, or stop.
template <class T, class Each>
std::vector<T> gathered(const std::vector<T>& values, const std::vector<std::uint32_t>& of,
                        const Each& each) {
  std::vector<T> result;
  if (values.empty()) return result;
  result.reserve(of.size());
  for (const std::uint32_t k : of) {
    each();
    result.push_back(values[k]);
  }
  return result;
}
template <class T>
std::vector<T> gathered(const std::vector<T>& values, const std::vector<std::uint32_t>& of) {
  return gathered(values, of, [] {});
}

}  // namespace fracture
