// The materials of the cut faces: each part's looks like what it was cut from.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/gltf/cut_detail.hpp"
#include "common/mesh/mesh.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// How the inside takes part in the look of the outside.
enum class InteriorChoice {
  kAuto,     ///< parts have the colour of their surfaces, as far as `mix` says; an atlas is not shown
  kPlain,    ///< all parts have the same colour, which is none of their surfaces'
  kTexture,  ///< as kAuto, but whatever textures `material` has are shown
};

/// Where textures lie on cut faces: their planar UVs, which are metres, times `scale`, plus (u, v).
struct CutUvs {
  double scale = 1;
  double u = 0, v = 0;
  friend bool operator==(const CutUvs&, const CutUvs&) = default;
};

/// Of cuts through what lets light through.
inline constexpr double kClearOpacity = 0.5;

/// What the inside looks like. Whatever is not set comes from the source's material named by `material`, or
/// else from a plain matt grey called "Interior".
struct InteriorLook {
  std::string material{};             ///< name or index of a material of the source, whose look is reused
  std::optional<std::string> name{};  ///< of the material in the file
  std::optional<Vec3d> color{};  ///< base colour, linear, 0 … 1; replaces the reused base colour texture
  std::optional<double> roughness{};  ///< 0 … 1
  std::optional<double> metallic{};   ///< 0 … 1
  std::optional<double> opacity{};    ///< 0 … 1; not set: 1, kClearOpacity where the surface is translucent
  InteriorChoice choice = InteriorChoice::kAuto;
  /// Share of the surface's colour in the base colour, 0 … 1; above 0 in the place of a texture. Not set: all where
  /// neither `material` nor `color` is, else none.
  std::optional<double> mix{};
  double shade = 0.8;  ///< how much of its light that colour keeps
  double crushed = 0;  ///< cuts of fragments below this share of the mean that is asked for are white, 0 … 1
  std::optional<Vec3d>
      mortar{};  ///< base colour of the joints between bricks, as `color`; none: as other cuts
  CutUvs uvs{};
  CutDetail detail = CutDetail::kNone;
  /// Whoever reads the file has the maps of `detail`, which are left out; the cuts lie under them all the same.
  bool has_maps = false;
  friend bool operator==(const InteriorLook&, const InteriorLook&) = default;
};

/// glTF material objects, and which of them the cuts of each part have.
struct InteriorMaterials {
  std::vector<nlohmann::json> materials{};  ///< at least one; all names begin with that of the first
  std::vector<std::uint32_t> of_part{};     ///< empty: all parts have the first
  /// Of the inner sides of walls, one for each of `materials` but those of mortar and of what is crushed, and of its
  /// look: empty where there are no walls.
  std::vector<nlohmann::json> cavities{};
  CutUvs uvs{};
  CutDetail detail = CutDetail::kNone;  ///< its two textures stand behind those of the source
  /// So many of the first `materials` have the normal map of a detail, here or in an earlier answer: their cuts need
  /// tangents.
  std::uint32_t in_relief = 0;
  /// The last of `materials` is for the cuts of fragments smaller than this, m³. 0: of none, and there is no such
  /// material.
  double crushed_below = 0;
  std::uint32_t mortar = kNoIndex;  ///< index into `materials`, for kMortarMaterial; kNoIndex: there is none

  /// Index into `materials` and `cavities`.
  std::uint32_t of(std::size_t part) const { return part < of_part.size() ? of_part[part] : 0; }
  /// Index into `materials`, for the cuts of a fragment of this volume.
  std::uint32_t of(std::size_t part, double fragment_volume) const {
    return fragment_volume < crushed_below ? static_cast<std::uint32_t>(materials.size() - 1) : of(part);
  }
};

/// Parts whose cuts look alike share one; there are at most so many, and those of mortar and of what is crushed.
inline constexpr std::size_t kMostInteriorMaterials = 16;

/// A reused material is called "Interior_<its name>", so that tools still tell cut faces from the outside. Its
/// textures tile with the planar UVs of the cuts, one repeat a metre, if they tile on the outside; an atlas or a
/// palette, of which a cut would show anything, gives its mean colour. kBadParameter (`interior_material`) with the
/// names there are in extra.known when the source has no such material. `pieces`: how many fragments are asked for, which says
/// what look.crushed is a share of: not how many there are, so that hits leave what they do not touch as it was.
/// Throws Interrupted.
Expected<InteriorMaterials> interior_materials(const InteriorLook& look, const Solid& solid,
                                               const Execution& execution = kUninterrupted,
                                               std::uint32_t pieces = 1);

/// The matt grey.
nlohmann::json plain_interior_material();

/// "#rrggbb" in sRGB (IEC 61966-2-1) to linear components; nothing for any other text.
std::optional<Vec3d> linear_color(std::string_view srgb_hex);

}  // namespace fracture
