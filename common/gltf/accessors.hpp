// The bufferViews and accessors of the file being written.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "common/gltf/json_text.hpp"
#include "common/gltf/vertex_data.hpp"

namespace fracture {

/// glTF's component types and bufferView targets.
inline constexpr int kFloat = 5126, kUnsignedShort = 5123, kUnsignedInt = 5125;
inline constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
/// 65,535 would be the restart index of a 16-bit strip and is not allowed as an index.
inline constexpr std::size_t kMaxShortVertices = 65535;

/// The bufferViews in the order they first get a byte, and the accessors into them, whose JSON grows
/// alongside.
class Accessors {
 public:
  struct View {
    ViewBytes bytes;
    int stride;  ///< 0 for indices and images
    int target;  ///< 0 for images
  };

  /// With room for this many vertices and indices in all: no view is moved while it grows.
  Accessors(std::size_t vertices, std::size_t indices) : vertices_(vertices), indices_(indices) {
    json_.begin_array();
  }

  std::size_t view(std::string_view name, int stride, int target) {
    for (std::size_t k = 0; k < names_.size(); ++k)
      if (names_[k] == name) return k;
    names_.emplace_back(name);
    views_.push_back({{}, stride, target});
    if (stride > 0) views_.back().bytes.reserve(static_cast<std::size_t>(stride) * vertices_);
    if (target == kElementArrayBuffer) views_.back().bytes.reserve(2 * indices_);
    return views_.size() - 1;
  }
  ViewBytes& bytes(std::size_t view) { return views_[view].bytes; }
  const std::vector<View>& views() const { return views_; }

  /// Begins an accessor over what is appended to the view from byte `offset` on; returns its index.
  std::size_t add(std::size_t view, std::size_t offset, int component, std::size_t count, const char* type,
                  const Vec3f* min = nullptr, const Vec3f* max = nullptr) {
    json_.begin_object().member("bufferView", view);
    if (offset > 0) json_.member("byteOffset", offset);
    json_.member("componentType", component).member("count", count).member("type", type);
    if (min != nullptr) json_.member("min", to_double(*min)).member("max", to_double(*max));
    json_.end_object();
    return count_++;
  }
  /// Begins an accessor whose members the caller writes; end it with end_object().
  JsonText& begin() {
    ++count_;
    return json_.begin_object();
  }
  std::string finish() {
    json_.end_array();
    return json_.take();
  }
  std::size_t count() const { return count_; }

 private:
  std::vector<std::string> names_;
  std::vector<View> views_;
  JsonText json_;
  std::size_t count_ = 0;
  std::size_t vertices_, indices_;
};

/// Appends indices of either width, 4-byte aligned; returns the byte offset of the first.
std::size_t append_indices(ViewBytes& view, const std::uint32_t* indices, std::size_t count, bool wide);

}  // namespace fracture
