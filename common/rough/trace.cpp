#include "common/rough/trace.hpp"

#include "common/base/heap_bytes.hpp"

namespace fracture {

std::size_t memory_size(const KeptCut& cut) {
  return sizeof cut + heap(cut.fixed) + heap(cut.flat) + heap(cut.moves) + heap(cut.triangles);
}

std::uint64_t places_of(std::span<const Calming> calmings) {
  std::uint64_t places = 0;
  for (std::size_t k = 0; k < calmings.size(); ++k)
    places += k == 0 || calmings[k].place != calmings[k - 1].place;
  return places;
}

}  // namespace fracture
