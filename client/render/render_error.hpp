// What can go wrong on this side of the wire. A refused mesh keeps the library's own words
// (common/base/error.hpp) in `detail`; its slug stands in front.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace fracture::render {

enum class RenderErrorCode {
  kNoDevice,  ///< no EGL display, or none that gives OpenGL 3.3 core
  kGl,    ///< a shader, framebuffer or texture was refused by the driver; the driver's words are in detail
  kMesh,  ///< the glTF is damaged or needs what is not supported
  kTooLarge,   ///< over a stated limit
  kFile,       ///< cannot be read or written
  kImage,      ///< cannot be decoded or encoded
  kBadOption,  ///< a value out of its range; detail names it and the range
};

struct RenderError {
  RenderErrorCode code;
  std::string detail;  ///< one or two sentences: what, where, and the limit
};

template <class T>
using Result = tl::expected<T, RenderError>;

inline tl::unexpected<RenderError> fail(RenderErrorCode code, std::string detail) {
  return tl::unexpected<RenderError>(RenderError{code, std::move(detail)});
}

}  // namespace fracture::render
