// The materials of the cut faces. The cuts of a part look like the part's surface.
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

/// How the look of the inside depends on that of the outside.
enum class InteriorChoice {
  kAuto,     ///< cuts get the colour of their part's surface, weighted by `mix`; no atlas is shown
  kPlain,    ///< all parts get the same colour, independent of their surfaces
  kTexture,  ///< as kAuto, but all textures of `material` are shown
};

/// Texture coordinates of cut faces: their planar UVs, which are in metres, times `scale`, plus (u, v).
struct CutUvs {
  double scale = 1;
  double u = 0, v = 0;
  friend bool operator==(const CutUvs&, const CutUvs&) = default;
};

/// Opacity of cuts through translucent parts.
inline constexpr double kClearOpacity = 0.5;

/// The look of the inside. Members that are not set come from the source's material `material`. If that is empty,
/// they come from a plain matt grey called "Interior".
struct InteriorLook {
  std::string material{};             ///< name or index of the source's material to reuse
  std::optional<std::string> name{};  ///< name of the material in the file
  std::optional<Vec3d> color{};  ///< base colour, linear, 0 … 1; replaces the reused base colour texture
  std::optional<double> roughness{};  ///< 0 … 1
  std::optional<double> metallic{};   ///< 0 … 1
  std::optional<double> opacity{};    ///< 0 … 1; not set: 1, or kClearOpacity if the surface is translucent
  InteriorChoice choice = InteriorChoice::kAuto;
  /// Share of the surface's colour in the base colour, 0 … 1. If above 0, the colour replaces a texture. Not set: 1 if neither
  /// `material` nor `color` is set, otherwise 0.
  std::optional<double> mix{};
  double shade = 0.8;  ///< factor for the brightness of the surface's colour
  double crushed = 0;  ///< 0 … 1: share of the requested mean volume; cuts of smaller fragments are white
  std::optional<Vec3d>
      mortar{};  ///< base colour of the joints between bricks, linear; not set: that of other cuts
  CutUvs uvs{};
  CutDetail detail = CutDetail::kNone;
  /// The client already has the maps of `detail`, so the file omits them. The cuts are made to fit them nevertheless.
  bool has_maps = false;
  friend bool operator==(const InteriorLook&, const InteriorLook&) = default;
};

/// glTF material objects for cuts, and which of them each part uses.
struct InteriorMaterials {
  std::vector<nlohmann::json> materials{};  ///< at least one; all names have the same stem
  std::vector<std::uint32_t> of_part{};     ///< empty: all parts use the first one
  /// Materials of the inner sides of walls. Each of `materials`, except mortar and crushed cuts, has one that looks the same.
  /// If the solid has no walls, the list is empty.
  std::vector<nlohmann::json> cavities{};
  CutUvs uvs{};
  CutDetail detail = CutDetail::kNone;  ///< its two textures follow those of the source
  /// Number of materials, from the first one, that have a detail's normal map (in this file, or already at the client). Their
  /// cuts need tangents.
  std::uint32_t in_relief = 0;
  /// m³: the cuts of fragments with a smaller volume look crushed. Their material is the last of `materials`.
  /// 0: no cuts look crushed.
  double crushed_below = 0;
  std::uint32_t mortar = kNoIndex;  ///< index into `materials`, for kMortarMaterial; kNoIndex: none
  /// If parts have looks of their own (part_materials.hpp): the last two members for each look. Crushed cuts then have an index.
  struct OfLook {
    double crushed_below = 0;
    std::uint32_t crushed = kNoIndex, mortar = kNoIndex;
  };
  std::vector<OfLook> looks{};
  std::vector<std::uint32_t> look_of_part{};

  /// Index into `materials` and `cavities` for the cuts of a part.
  std::uint32_t of(std::size_t part) const { return part < of_part.size() ? of_part[part] : 0; }
  /// Index into `materials` for the cuts of a fragment with this volume (m³).
  std::uint32_t of(std::size_t part, double fragment_volume) const {
    const OfLook look = look_of(part);
    return fragment_volume < look.crushed_below ? look.crushed : of(part);
  }
  /// Index into `materials` for the mortar of a part, or kNoIndex.
  std::uint32_t mortar_of(std::size_t part) const { return look_of(part).mortar; }

 private:
  OfLook look_of(std::size_t part) const {
    if (part < look_of_part.size()) return looks[look_of_part[part]];
    return {crushed_below, static_cast<std::uint32_t>(materials.size() - 1), mortar};
  }
};

/// Maximum number of materials, not counting those of mortar and crushed cuts. Parts whose cuts look alike share one.
inline constexpr std::size_t kMostInteriorMaterials = 16;

/// A reused material is called "Interior_<its name>", so that tools still recognize cut faces. If its textures tile on the
/// outside, they also tile on the cuts, once per metre of the planar UVs. An atlas or a palette is replaced by its mean
/// colour, because a cut would show arbitrary places of it. Error: kBadParameter (`interior_material`) if the source has no
/// such material; extra.known lists the names it has. `pieces`: the requested number of fragments, which defines the mean
/// volume for look.crushed. The actual number would not do: a hit would change fragments that it does not touch.
/// Throws Interrupted.
Expected<InteriorMaterials> interior_materials(const InteriorLook& look, const Solid& solid,
                                               const Execution& execution = kUninterrupted,
                                               std::uint32_t pieces = 1);

/// Returns the plain matt grey.
nlohmann::json plain_interior_material();

/// Converts "#rrggbb" in sRGB (IEC 61966-2-1) to linear components. Returns nothing for any other text.
std::optional<Vec3d> linear_color(std::string_view srgb_hex);

}  // namespace fracture
