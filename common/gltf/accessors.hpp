// The accessors of the file being written, and the buffer behind them.
#pragma once

#include <cstddef>
#include <string>

#include "common/gltf/buffer_contents.hpp"
#include "common/gltf/json_text.hpp"

namespace fracture {

/// 65,535 would be the restart index of a 16-bit strip and is not allowed as an index.
inline constexpr std::size_t kMaxShortVertices = 65535;

/// The accessors, whose JSON grows alongside that of the meshes.
class Accessors {
 public:
  /// Borrowed.
  explicit Accessors(const Execution& execution) : execution_(execution), json_(execution) {
    json_.begin_array();
  }

  const Execution& execution() const { return execution_; }
  BufferContents& contents() { return contents_; }
  /// Almost all have an array of their own.
  void expect(std::size_t accessors) {
    json_.reserve(accessors * 130);
    contents_.expect(accessors);
  }

  /// Over what lies in the view from byte `offset` on; returns the accessor's index.
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
  BufferContents contents_;
  JsonText json_;
  std::size_t count_ = 0;
};

}  // namespace fracture
