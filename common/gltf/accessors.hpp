// The accessors of the file being written, and the buffer behind them.
#pragma once

#include <cstddef>
#include <string>

#include "common/gltf/buffer_contents.hpp"
#include "common/gltf/json_text.hpp"

namespace fracture {

/// A 16-bit index may not be 65,535, because that value restarts a strip.
inline constexpr std::size_t kMaxShortVertices = 65535;

/// Collects the accessors. Their JSON is written at the same time as that of the meshes.
class Accessors {
 public:
  /// `execution` is borrowed.
  explicit Accessors(const Execution& execution) : execution_(execution), json_(execution) {
    json_.begin_array();
  }

  const Execution& execution() const { return execution_; }
  BufferContents& contents() { return contents_; }
  /// Reserves memory. Almost every accessor has its own array.
  void expect(std::size_t accessors) {
    json_.reserve(accessors * 130);
    contents_.expect(accessors);
  }

  /// Adds an accessor to the view's data from byte `offset` on. Returns the accessor's index.
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
