// The vertices of a solid, and of the surface that it is made of.
#pragma once

#include "common/base/id.hpp"

namespace fracture {

using VertexId = Id<struct VertexTag>;
inline constexpr VertexId kNoVertex{0xffffffffu};

}  // namespace fracture
