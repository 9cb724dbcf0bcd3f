// What a fracture starts from: sites in their tetrahedralization, or an earlier answer that is hit.
#pragma once

#include <variant>

#include "common/hits/delta.hpp"

namespace fracture {

using CutBase = std::variant<Diagram, FracturedBase>;

}  // namespace fracture
