// Materials by name. Each is a preset for the pattern (sites/pattern.hpp), and for the density, friction, bounce, strength and
// look of the fragments. A caller can override every value.
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
  double friction = 0.6;     ///< static and dynamic, between two bodies of the material
  double restitution = 0.1;  ///< 0 … 1
  /// Pascals: the tension that a bond withstands before it breaks.
  double bond_strength = 1e6;
  friend bool operator==(const PhysicalProperties&, const PhysicalProperties&) = default;
};

/// The look of a cut face: its own colour, blended with the colour of the outside. If `exterior` applies the material to the
/// outside, the outside gets the same colour, metalness and opacity, and the roughness `outside_roughness`.
struct CutLook {
  const char* color;  ///< sRGB as "#rrggbb"
  double mix;         ///< share of the outside's mean colour, 0 … 1
  double shade;       ///< factor for the brightness of the outside's mean colour; above 1: brighter
  double roughness, metallic;
  double outside_roughness;
  std::optional<double> opacity{};  ///< none: the opacity of the outside
  double crushed = 0;               ///< as InteriorLook::crushed
};

/// A fraction of the mean volume. Every material merges smaller fragments with a neighbour. Such crumbs are invisible, but
/// cost as much as other fragments.
inline constexpr double kLeastOfMean = 0.002;

/// Objects made of glass, pottery and sheet metal are hollow, but their meshes are solid. A part becomes hollow if it can contain a
/// ball of this diameter, as a fraction of its longest side. Panes, rods and legs cannot.
inline constexpr double kLeastBall = 0.2;

struct MaterialPreset {
  const char* name;
  const char* doc;  ///< one sentence for people
  SitePattern pattern;
  std::uint32_t lloyd;
  double stretch;  ///< along the grain; without `grain`, each part has its own (GrainOf::kPart)
  Roughness roughness;
  PhysicalProperties physical;
  CutLook look;
  const char* source;            ///< of the physical values
  std::optional<Vec3d> grain{};  ///< one direction for all parts, such as the bedding of sandstone
  double shell_fraction = 0;     ///< wall thickness as a fraction of a part's longest side (see kLeastBall)
  Aggregation aggregation{};
};

std::span<const MaterialPreset> material_presets();
/// Null if no material has this name.
const MaterialPreset* find_material_preset(std::string_view name);
/// The size of most pieces of broken objects of this material, m. The values are rough: they serve only to find objects that are
/// a thousand times as large. 0 if no material has this name.
double usual_piece(std::string_view name);

}  // namespace fracture
