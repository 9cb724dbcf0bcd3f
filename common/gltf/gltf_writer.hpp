// Fragments out: one GLB that standard tools read (glTF 2.0 core), with figures, bonds and certificate in extras.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/fragment/fragments.hpp"

namespace fracture {

/// What the file says beside the geometry. No time stamps, no host names: identical requests give identical bytes.
struct GltfOptions {
  nlohmann::json parameters = nlohmann::json::object();  ///< the canonical request, for asset.extras and extras.fracture
  std::string mesh_digest;                               ///< "sha256:…" of the input bytes
  int algorithm = 1;                                     ///< version of the algorithm
};

std::vector<std::uint8_t> write_glb(const FragmentSet& fragments, const GltfOptions& options);
/// The `extras.fracture` object of the root node: {version, mesh, parameters, report, certificate, bonds}.
nlohmann::json fracture_extras(const FragmentSet& fragments, const GltfOptions& options);

}  // namespace fracture
