#include "common/gltf/accessors.hpp"

#include <cstring>

namespace fracture {

std::size_t append_indices(ViewBytes& view, const std::uint32_t* indices, std::size_t count, bool wide) {
  view.align(4);
  const std::size_t at = view.size();
  if (wide) {
    std::memcpy(view.extend(count * 4), indices, count * 4);
    return at;
  }
  std::uint8_t* out = view.extend(count * 2);
  for (std::size_t k = 0; k < count; ++k, out += 2) {
    const auto narrow = static_cast<std::uint16_t>(indices[k]);
    std::memcpy(out, &narrow, 2);
  }
  return at;
}

}  // namespace fracture
