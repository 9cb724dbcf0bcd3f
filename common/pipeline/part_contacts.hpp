// Which pieces of different parts touch: these may become one fragment (parts=together).
#pragma once

#include <optional>

#include "common/clip/restricted_diagram.hpp"
#include "common/fragment/unite.hpp"
#include "common/pipeline/fracture.hpp"

namespace fracture {

/// Whether parts are fractured together, and any contact between them has an area.
bool joins_parts(const Solid& solid, const FractureParameters& parameters);

/// The contacts of pieces across parts, and the groups of parts that hold together. Empty unless joins_parts(). Two pieces in
/// one cell whose parts overlap are in contact even if no contact surface is in both: if they share a Voronoi vertex, or
/// if one is inside the other. `flat`: with flat cuts. Near-linear, as find_contact_bonds(). Throws Interrupted.
std::optional<PartContacts> find_part_contacts(const RestrictedDiagram& flat, const Ownership& ownership,
                                               const Pieces& pieces, const FractureParameters& parameters,
                                               const Execution& execution);

}  // namespace fracture
