// The Hilbert curve through a lattice: neighbours on it are neighbours in space, so that what is stored in its
// order and used together lies together. Hamilton 2006, "Compact Hilbert indices", without the compaction.
#pragma once

#include <cstdint>

namespace fracture {

/// Position on the Hilbert curve of a 2^bits lattice, coordinates below 2^bits, bits <= 21.
std::uint64_t hilbert_index(std::uint32_t x, std::uint32_t y, std::uint32_t z, int bits);

}  // namespace fracture
