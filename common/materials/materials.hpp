// Materials by name: how each breaks, and what its pieces weigh, rub, bounce, hold and look like. Presets
// over the patterns (sites/pattern.hpp); a caller may override every value.
#pragma once

#include <cstdint>
#include <optional>
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

/// The look of a cut face: a colour of its own, mixed with that of the outside. The outside of what is made of the material
/// all over has the same colour, metal and opacity, and a roughness of its own.
struct CutLook {
  const char* color;  ///< sRGB as "#rrggbb"
  double mix;         ///< share of the outside's mean colour, 0 … 1
  double shade;       ///< how much of its light that mean keeps; above 1: what was cut is brighter
  double roughness, metallic;
  double outside_roughness;
  std::optional<double> opacity{};  ///< none: as the surface's
  double crushed = 0;               ///< as InteriorLook::crushed
};

/// Every material unites smaller fragments than this fraction of the mean with a neighbour: crumbs that nobody
/// sees cost as much as others.
inline constexpr double kLeastOfMean = 0.002;

/// Things of glass, pottery and sheet metal are hollow, their meshes are not. What holds a ball of this diameter, as a fraction of
/// its longest side, is such a thing; panes, rods and legs are not.
inline constexpr double kLeastBall = 0.2;

struct MaterialPreset {
  const char* name;
  const char* doc;  ///< one sentence for people
  SitePattern pattern;
  std::uint32_t lloyd;
  double stretch;  ///< along the grain, which is that of each part (GrainOf::kPart) where there is no `grain`
  Roughness roughness;
  PhysicalProperties physical;
  CutLook look;
  const char* source;            ///< of the physical figures
  std::optional<Vec3d> grain{};  ///< the same for all: how it lay in the ground, say
  double shell_fraction = 0;     ///< of the longest side of a part that holds a ball of kLeastBall: its walls
  Aggregation aggregation{};
};

std::span<const MaterialPreset> material_presets();
/// Null when there is none of this name.
const MaterialPreset* find_material_preset(std::string_view name);

}  // namespace fracture
