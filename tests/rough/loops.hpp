// Closed loops of points in a plane, stored one after another, as rough cuts take them.
#pragma once

#include <cstdint>
#include <vector>

namespace fracture::test {

template <class Point>
struct Loops {
  std::vector<Point> points;
  std::vector<std::uint32_t> begin{0};  ///< loop k is points [begin[k], begin[k + 1])
  void add(const std::vector<Point>& loop) {
    points.insert(points.end(), loop.begin(), loop.end());
    begin.push_back(static_cast<std::uint32_t>(points.size()));
  }
};

}  // namespace fracture::test
