// Heap bytes behind containers, for code that accounts for memory.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace fracture {

template <class T>
std::size_t heap(const std::vector<T>& v) {
  return v.capacity() * sizeof(T);  // NOLINT(bugprone-sizeof-expression): pointers count with their own size
}
template <class T>
std::size_t nested_heap(const std::vector<std::vector<T>>& v) {
  std::size_t bytes = heap(v);
  for (const std::vector<T>& inner : v) bytes += heap(inner);
  return bytes;
}
inline std::size_t heap(const std::vector<std::string>& texts) {
  std::size_t bytes = texts.capacity() * sizeof(std::string);
  for (const std::string& text : texts) bytes += text.capacity();
  return bytes;
}

}  // namespace fracture
