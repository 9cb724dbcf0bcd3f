// The two containers of glTF 2.0: GLB, and JSON with the buffer in a data URI.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/gltf/accessors.hpp"
#include "common/gltf/json_text.hpp"

namespace fracture {

/// Writes the member bufferViews; returns the length of the buffer they lie in, each 4-byte aligned.
std::size_t write_views(JsonText& json, const std::vector<Accessors::View>& views);

/// Where the text begins in a GLB: behind its header and that of the chunk (glTF 2.0, section 4.4).
inline constexpr std::size_t kGlbText = 20;

/// Completes the document that `json` holds (its object is still open) with the member buffers and wraps both
/// up. The views are emptied. Throws InternalError beyond 4 GiB, Interrupted.
std::vector<std::uint8_t> pack_glb(JsonText json, std::vector<Accessors::View>& views, std::size_t buffer,
                                   const Execution& execution);
/// As pack_glb: the JSON text, the buffer as base64 (RFC 4648) inside it.
std::vector<std::uint8_t> pack_gltf(JsonText json, std::vector<Accessors::View>& views, std::size_t buffer,
                                    const Execution& execution);

}  // namespace fracture
