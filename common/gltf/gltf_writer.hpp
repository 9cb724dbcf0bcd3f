// Fragments out: one GLB that standard tools read (glTF 2.0 core, nothing required), with figures, bonds and
// certificate in extras. The same fragments and options give the same bytes.
//
//   scene ── root (identity; extras.fracture: report, certificate, bonds)
//             ├─ fragment 0 (translation = pivot; extras.fracture: id, volume, …) ── mesh 0: exterior
//             primitives, interior └─ fragment 1 …
//
// All fragments share one bufferView for each attribute and one for the indices; the primitives of a mesh
// share their attribute accessors. World positions are float32(local) + float32(translation), exact by
// construction (I2).
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/fragment/fragments.hpp"

namespace fracture {

/// What the file says beside the geometry. No time stamps, no host names: identical requests give identical
/// bytes.
struct GltfOptions {
  nlohmann::json parameters =
      nlohmann::json::object();  ///< the canonical request, for asset.extras and extras.fracture
  std::string mesh_digest;       ///< "sha256:…" of the input bytes
  int algorithm = 1;             ///< version of the algorithm
  double density = 1000;         ///< kg/m³, for the mass of each fragment
  /// The material of the cut faces as a glTF material object; its name should contain "Interior" (that is how
  /// tools tell cut faces from the outside). Textures are indices into the source's.
  nlohmann::json interior_material = {
      {"name", "Interior"},
      {"pbrMetallicRoughness",
       {{"baseColorFactor", {0.55, 0.5, 0.45, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 0.9}}}};
};

/// Throws InternalError when a fragment contradicts its own description (attribute lengths, index ranges,
/// primitives that do not cover the indices) or the file would pass 4 GiB.
std::vector<std::uint8_t> write_glb(const FragmentSet& fragments, const GltfOptions& options);
/// The `extras.fracture` object of the root node: {version, mesh, parameters, report, certificate, bonds}.
nlohmann::json fracture_extras(const FragmentSet& fragments, const GltfOptions& options);

}  // namespace fracture
