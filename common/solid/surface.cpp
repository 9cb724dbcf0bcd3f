#include "common/solid/surface.hpp"

#include "common/solid/polled.hpp"

namespace fracture::solid_detail {

void Surface::remove(const std::vector<std::uint8_t>& doomed, const Execution& execution) {
  std::size_t kept = 0;
  for_each_polled(execution, triangles.size(), [&](std::size_t t) {
    if (doomed[t]) return;
    triangles[kept] = triangles[t];
    source[kept] = source[t];
    if (!flipped.empty()) flipped[kept] = flipped[t];
    ++kept;
  });
  triangles.resize(kept);
  source.resize(kept);
  if (!flipped.empty()) flipped.resize(kept);
  twin.of_triangle.clear();
}

}  // namespace fracture::solid_detail
