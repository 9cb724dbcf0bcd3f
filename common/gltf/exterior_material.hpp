// The materials of the outside of fragments: those that the asset brings, or what a preset makes of them.
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
  kAuto,      ///< what has no material of its own is made of the preset's
  kAsset,     ///< all as the asset has it
  kMaterial,  ///< everything is made of the preset's material, in the colours that it has
};

/// What the outside of a thing of some material is like. Without a value nothing is known of it.
struct ExteriorLook {
  ExteriorChoice choice = ExteriorChoice::kAuto;
  std::optional<Vec3d> color{};       ///< base colour of what has none, linear, 0 … 1
  std::optional<double> roughness{};  ///< 0 … 1
  std::optional<double> metallic{};   ///< 0 … 1
  std::optional<double> opacity{};    ///< 0 … 1; not set: as the surface's
  bool any() const { return color || roughness || metallic || opacity; }
  friend bool operator==(const ExteriorLook&, const ExteriorLook&) = default;
};

/// glTF material objects beside those of the source, which stay as they are: parts that are not fractured have them, too.
struct ExteriorMaterials {
  std::vector<nlohmann::json> materials{};
  /// Per material of the source, and last of what has none: index into `materials`; kNoIndex: the source's own.
  std::vector<std::uint32_t> of_source{};

  /// Index into `materials` for a material of the source (or kNoIndex); kNoIndex: as the source has it.
  std::uint32_t of(std::uint32_t source) const {
    if (of_source.empty()) return kNoIndex;
    return of_source[source < of_source.size() ? source : of_source.size() - 1];
  }
};

/// Names are those of the source's materials, "Exterior" of what has none. Colours of vertices stay: they are factors of a
/// white base colour. Throws Interrupted.
ExteriorMaterials exterior_materials(const ExteriorLook& look, const Mesh& source,
                                     const Execution& execution = kUninterrupted);

}  // namespace fracture
