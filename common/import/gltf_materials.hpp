// Materials, textures, samplers and images of a glTF, set aside as they are: JSON stays JSON, image bytes
// stay bytes.
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

/// Extensions that only concern materials, textures and images: passed through without being understood.
bool is_material_extension(const std::string& name);

using ViewBytes =
    std::function<std::span<const std::uint8_t>(std::uint64_t view, const std::string& pointer)>;

/// Images come from bufferViews, data uris and parts of the upload. An image that is in none of these is
/// dropped with a warning, and with it every texture that shows it and every reference to such a texture.
/// Throws Refused.
MaterialLibrary read_materials(const nlohmann::json& document, const ViewBytes& view_bytes,
                               std::span<const ImportFile> files, Remarks& remarks);

/// "image/png" … from the first bytes; empty when they are of no known kind.
std::string sniff_image(std::span<const std::uint8_t> bytes);

/// The warning about an image that the mesh names but that was not uploaded.
std::string in_another_file(std::string_view image);

}  // namespace fracture
