#include "common/gltf/accessors.hpp"

#include <algorithm>
#include <cstring>

namespace fracture {

std::size_t append_indices(ViewBytes& view, const std::uint32_t* indices, std::size_t count, bool wide) {
  view.align(4);
  const std::size_t at = view.size();
  if (wide) {
    view.append(indices, count * 4);
    return at;
  }
  constexpr std::size_t kBlock = 16384;  // between two polls
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t end = std::min(count, begin + kBlock);
    std::uint8_t* out = view.extend((end - begin) * 2);
    for (std::size_t k = begin; k < end; ++k, out += 2) {
      const auto narrow = static_cast<std::uint16_t>(indices[k]);
      std::memcpy(out, &narrow, 2);
    }
  }
  return at;
}

}  // namespace fracture
