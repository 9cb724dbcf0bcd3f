// The two containers of glTF 2.0: GLB, and JSON with the buffer in a data URI.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/gltf/buffer_contents.hpp"
#include "common/gltf/json_text.hpp"

namespace fracture {

/// Writes the member bufferViews, if there are any views.
void write_views(JsonText& json, const BufferContents& contents);

/// Offset of the JSON text in a GLB: it follows the file header and the chunk header (glTF 2.0, section 4.4).
inline constexpr std::size_t kGlbText = 20;

/// Completes the document in `json`, whose object is still open, with the member buffers, and writes the buffer's contents
/// after it. Throws InternalError if the file would exceed 4 GiB, and Interrupted.
std::vector<std::uint8_t> pack_glb(JsonText json, const BufferContents& contents, const Execution& execution);
/// Like pack_glb(), but returns JSON text that contains the buffer as base64 (RFC 4648).
std::vector<std::uint8_t> pack_gltf(JsonText json, const BufferContents& contents,
                                    const Execution& execution);

}  // namespace fracture
