// Distinguishes open pieces that are sheets from bodies with holes.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/sheets.hpp"
#include "common/solid/shells.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Per shell: 1 if it is flat or walled, or if it encloses, with its filled holes, less than `thickness` (metres) times
/// the area of its source triangles. Open pieces that enclose more remain bodies, and the report gets a note
/// about them.
std::vector<std::uint8_t> find_open_sheets(const Surface& surface, const Shells& shells, double thickness,
                                           const Walled& walled, SolidReport& report,
                                           const Execution& execution);

}  // namespace fracture::solid_detail
