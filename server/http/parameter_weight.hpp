// How long parameters take to parse. Most take about as long as their bytes suggest, but some do not.
#pragma once

#include <cstdint>
#include <vector>

#include "common/parameters/parameters.hpp"

namespace fracture::http {

/// Returns the number of bytes of ordinary parameters that take as long to parse (kParseInline). `bytes`: of these parameters as text. An
/// entry of `assign` is a whole set of parameters, in as few as seven bytes. A name that does not exist is compared with all that do.
/// Each of them counts as kBytesOfRow bytes more. Linear in the parameters.
std::uint64_t parse_weight(std::uint64_t bytes, const std::vector<RawParameter>& given,
                           const ParameterTable& table);
inline constexpr std::uint64_t kBytesOfRow = 100;

}  // namespace fracture::http
