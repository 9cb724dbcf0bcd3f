// Materials by name: how each breaks, and what its pieces weigh, rub, bounce, hold and look like. Presets
// over the patterns (sites/pattern.hpp); a caller may override every value.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "common/rough/roughness.hpp"
#include "common/sites/pattern.hpp"

namespace fracture {

struct PhysicalProperties {
  double density = 1000;     ///< kg/m³
  double friction = 0.6;     ///< static and dynamic, on itself
  double restitution = 0.1;  ///< 0 … 1
  /// Pascals: what a bond's area withstands in tension before it breaks.
  double bond_strength = 1e6;
  friend bool operator==(const PhysicalProperties&, const PhysicalProperties&) = default;
};

/// The look of a cut face: a colour of its own, mixed with that of the outside.
struct CutLook {
  const char* color;  ///< sRGB as "#rrggbb"
  double mix;         ///< share of the outside's mean colour, 0 … 1
  double shade;       ///< how much of its light that mean keeps; above 1: what was cut is brighter
  double roughness, metallic;
};

/// Every material unites smaller fragments than this fraction of the mean with a neighbour: crumbs that nobody
/// sees cost as much as others.
inline constexpr double kLeastOfMean = 0.002;

struct MaterialPreset {
  const char* name;
  const char* doc;  ///< one sentence for people
  SitePattern pattern;
  std::uint32_t lloyd;
  double stretch;  ///< along the grain, whose default direction is the longest side of the box
  Roughness roughness;
  PhysicalProperties physical;
  CutLook look;
  const char* source;  ///< of the physical figures
};

std::span<const MaterialPreset> material_presets();
/// Null when there is none of this name.
const MaterialPreset* find_material_preset(std::string_view name);

}  // namespace fracture
