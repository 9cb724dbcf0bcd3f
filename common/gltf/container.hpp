// The two containers of glTF 2.0: GLB, and JSON with the buffer in a data URI.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/gltf/buffer_contents.hpp"
#include "common/gltf/json_text.hpp"

namespace fracture {

/// Writes the member bufferViews, where there are any.
void write_views(JsonText& json, const BufferContents& contents);

/// Where the text begins in a GLB: behind its header and that of the chunk (glTF 2.0, section 4.4).
inline constexpr std::size_t kGlbText = 20;

/// Completes the document that `json` holds (its object is still open) with the member buffers and writes the contents
/// behind it. Throws InternalError beyond 4 GiB, Interrupted.
std::vector<std::uint8_t> pack_glb(JsonText json, const BufferContents& contents, const Execution& execution);
/// As pack_glb: the JSON text, the buffer as base64 (RFC 4648) inside it.
std::vector<std::uint8_t> pack_gltf(JsonText json, const BufferContents& contents,
                                    const Execution& execution);

}  // namespace fracture
