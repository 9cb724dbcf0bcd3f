// Materials, textures, samplers and images of a glTF, kept unchanged: JSON stays JSON, and image bytes stay
// bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/remarks.hpp"
#include "common/import/import.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// Whether an extension concerns only materials, textures and images. Such extensions are copied without
/// being interpreted.
bool is_material_extension(const std::string& name);

using ViewBytes =
    std::function<std::span<const std::uint8_t>(std::uint64_t view, const std::string& pointer)>;

/// Reads the materials. Images come from bufferViews, data uris and files of the upload. Any other image is
/// dropped with a warning and an entry in `dropped`, together with every texture that uses it and every reference to such a
/// texture. Throws Refused.
MaterialLibrary read_materials(const nlohmann::json& document, const ViewBytes& view_bytes,
                               std::span<const ImportFile> files, Remarks& remarks,
                               std::vector<Dropped>& dropped);

/// Returns "image/png" … from the first bytes; empty if the kind is unknown.
std::string sniff_image(std::span<const std::uint8_t> bytes);

/// The warning about an image that the mesh refers to but that was not uploaded.
std::string in_another_file(std::string_view image);

}  // namespace fracture
