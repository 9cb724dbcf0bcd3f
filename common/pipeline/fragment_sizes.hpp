// The volumes that fragments are to have: Weibull's distribution ("A statistical distribution function of wide
// applicability", 1951), in numbers of fragments:
//
//   N(> v) / N = exp(-(v / scale)^(1 / spread))
//
// spread 0: all alike. 1: the exponential distribution of Grady & Kipp ("Geometric statistics and dynamic
// fragmentation", J. Appl. Phys. 58, 1985), the large fragments of a Poisson process of cracks; Åström, Ouchterlony,
// Linna & Timonen ("Universal dynamic fragmentation in D dimensions", Phys. Rev. Lett. 92, 245506, 2004) find it in
// quarry blasts and in the crushing of granitic gneiss, beside a power law of fines, which here are dust: nobody makes
// them. 2: that of Mott & Linfoot (1943).
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/pacer.hpp"

namespace fracture {

/// `count` volumes as parts of their sum, ascending: the quantiles in the middles of equal shares of probability, so that
/// their own distribution is off by no more than 1 / (2 count). The same bits everywhere.
std::vector<double> fragment_sizes(std::uint32_t count, double spread, Pacer& pacer);

}  // namespace fracture
