// The ids of a solid's vertices, and of the vertices of the surface that it is made from.
#pragma once

#include "common/base/id.hpp"

namespace fracture {

using VertexId = Id<struct VertexTag>;
inline constexpr VertexId kNoVertex{0xffffffffu};

}  // namespace fracture
