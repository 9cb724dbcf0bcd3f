// The bufferViews and accessors of the file being written.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "common/gltf/json_text.hpp"
#include "common/gltf/vertex_data.hpp"

namespace fracture {

/// glTF's bufferView targets.
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

  /// Borrowed.
  explicit Accessors(const Execution& execution) : execution_(execution), json_(execution) {
    json_.begin_array();
  }

  const Execution& execution() const { return execution_; }
  std::size_t view(const std::string& name, int stride, int target) {
    const auto [at, fresh] = number_.try_emplace(name, views_.size());
    if (fresh) views_.push_back({ViewBytes(execution_), stride, target});
    return at->second;
  }
  ViewBytes& bytes(std::size_t view) { return views_[view].bytes; }
  std::vector<View>& views() { return views_; }

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
  const Execution& execution_;
  std::map<std::string, std::size_t> number_;  // of views
  std::vector<View> views_;
  JsonText json_;
  std::size_t count_ = 0;
};

/// Appends indices of either width, 4-byte aligned; returns the byte offset of the first. Throws Interrupted.
std::size_t append_indices(ViewBytes& view, const std::uint32_t* indices, std::size_t count, bool wide);

}  // namespace fracture
