// Explains why an answer has fewer fragments than the request asks for.
#pragma once

#include <string>

#include "common/fragment/fragments.hpp"
#include "common/pipeline/fracture.hpp"

namespace fracture {

/// A kept share above this is everything but rounding.
inline constexpr double kAllKept = 1 - 1e-9;

/// The parameters that set the kept region, in quotes.
std::string names_of(const Region& region);

/// The size limits that are set, in quotes.
std::string names_of(const SizeLimits& size);

/// Whether at least a tenth of the pieces were inside out (SizeFigures::inside_out).
bool are_many_inside_out(const FragmentSet& set);

/// Returns the cause with the largest effect and what to do, after "because ". `asked`: the number of fragments, more than `set` has.
/// `kept_share`: of the solid's volume, 0 … 1. `instances`: whether instances may stay whole.
std::string why_fewer(std::uint32_t asked, const FractureParameters& parameters, double kept_share,
                      bool instances, const FragmentSet& set);

}  // namespace fracture
