// The starting point of a fracture: the tetrahedralized sites, or an earlier answer that new hits are applied to.
#pragma once

#include <variant>

#include "common/hits/delta.hpp"

namespace fracture {

using CutBase = std::variant<Diagram, FracturedBase>;

}  // namespace fracture
