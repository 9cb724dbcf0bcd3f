// Finds pieces of different parts that touch. They may become one fragment (parts=together).
#pragma once

#include <optional>

#include "common/clip/restricted_diagram.hpp"
#include "common/fragment/unite.hpp"
#include "common/pipeline/fracture.hpp"

namespace fracture {

/// Whether pieces of different parts can become one fragment: parts are fractured together and any contact between them has an
/// area, or instances may stay whole.
bool joins_parts(const Solid& solid, const FractureParameters& parameters);

/// Returns the contacts of pieces across parts, and the groups of parts that hold together. Returns nothing
/// unless joins_parts(). With Parts::kInstances, returns only the instances that stay whole; nothing if there are none.
/// Otherwise, two pieces in one cell whose parts overlap are in contact even if they share no
/// contact surface, provided that they share a Voronoi vertex or one is inside the other. `flat`: the
/// diagram with flat cuts. Near-linear, like find_contact_bonds(). Throws Interrupted.
std::optional<PartContacts> find_part_contacts(const RestrictedDiagram& flat, const Ownership& ownership,
                                               const Pieces& pieces, const FractureParameters& parameters,
                                               const Execution& execution);

}  // namespace fracture
