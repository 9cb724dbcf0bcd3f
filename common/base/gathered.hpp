// Selects elements of a list, in a given order.
#pragma once

#include <cstdint>
#include <vector>

namespace fracture {

/// Returns values[k] for each k of `of`, or an empty list if `values` is empty (an attribute that the mesh
/// lacks). Calls `each` for every element, so that callers can poll.
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
