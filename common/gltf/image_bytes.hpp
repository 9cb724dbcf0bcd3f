// Images on their way into the file.
#pragma once

#include "common/gltf/vertex_data.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture {

/// Appends the image byte for byte, less those chunks of a PNG that state another colour space than sRGB's
/// (iCCP; gAMA and cHRM with other values) or pixels that are not square (pHYs). glTF 2.0 (3.8.3, images)
/// tells readers to ignore them, and the Khronos validator warns of them (IMAGE_FEATURES_UNSUPPORTED). The
/// pixels are untouched. A PNG that cannot be followed chunk by chunk is copied as it is.
void append_image(ViewBytes& view, const Image& image);

}  // namespace fracture
