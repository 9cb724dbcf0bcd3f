// Which glTF extensions the reader applies, which it can leave out because they do not touch triangles, and which it refuses.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/mesh/dropped.hpp"

namespace fracture {

/// Refuses a document that requires an extension that is neither applied, nor a material's, nor known to leave the triangles
/// as they are. An unknown extension could change them. Throws Refused (kUnsupportedFeature, with the extension's name).
void check_required_extensions(const nlohmann::json& document);

/// Returns an entry for each extension that the document lists or contains and the answer does not, by name.
std::vector<Dropped> dropped_extensions(const nlohmann::json& document);

/// The compressed form of a bufferView: EXT_meshopt_compression, or its successor KHR_meshopt_compression. `name` is null if
/// the view has none.
struct MeshoptView {
  const char* name = nullptr;
  const nlohmann::json* extension = nullptr;
};
MeshoptView meshopt_view(const nlohmann::json& view);

}  // namespace fracture
