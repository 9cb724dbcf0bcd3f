// The materials of the outside of fragments: those of the asset, possibly changed by a preset.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

enum class ExteriorChoice {
  kAuto,      ///< surfaces without a material get the preset's
  kAsset,     ///< all surfaces stay as they are in the asset
  kMaterial,  ///< all surfaces get the preset's properties, but keep their colours
};

/// The look of the outside of an object made of a certain material. Properties without a value are unknown.
struct ExteriorLook {
  ExteriorChoice choice = ExteriorChoice::kAuto;
  std::optional<Vec3d> color{};       ///< base colour of surfaces without one, linear, 0 … 1
  std::optional<double> roughness{};  ///< 0 … 1
  std::optional<double> metallic{};   ///< 0 … 1
  std::optional<double> opacity{};    ///< 0 … 1; not set: that of the surface
  bool any() const { return color || roughness || metallic || opacity; }
  friend bool operator==(const ExteriorLook&, const ExteriorLook&) = default;
};

/// Additional glTF material objects. The source's materials stay unchanged, because parts that are not fractured use them.
struct ExteriorMaterials {
  std::vector<nlohmann::json> materials{};
  /// For each material of the source, then for surfaces without one: index into `materials`. kNoIndex: the source's own.
  std::vector<std::uint32_t> of_source{};

  /// If parts have looks of their own (part_materials.hpp): `of_source` for each look.
  std::vector<std::vector<std::uint32_t>> looks{};
  std::vector<std::uint32_t> look_of_part{};

  /// Index into `materials` for a material of the source (kNoIndex: none) on a part. Returns kNoIndex if the source's own is
  /// used.
  std::uint32_t of(std::uint32_t source, std::size_t part = 0) const {
    const std::vector<std::uint32_t>& list =
        part < look_of_part.size() ? looks[look_of_part[part]] : of_source;
    if (list.empty()) return kNoIndex;
    return list[source < list.size() ? source : list.size() - 1];
  }
};

/// Materials keep the names of the source's materials; the one for surfaces without a material is called "Exterior",
/// or "Exterior_2" and so on if the source has a material of that name. If the source has vertex colours, that one is white,
/// because vertex colours multiply it. Throws Interrupted.
ExteriorMaterials exterior_materials(const ExteriorLook& look, const Mesh& source,
                                     const Execution& execution = kUninterrupted);

}  // namespace fracture
