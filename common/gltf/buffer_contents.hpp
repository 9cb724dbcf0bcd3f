// The contents of the file's buffer: its bufferViews, and the position of each mesh's arrays in them. The JSON text comes
// before the buffer in the file and needs only the sizes of the arrays. So the sizes are determined first. Then all threads
// write the arrays directly to their final positions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/base/pacer.hpp"

namespace fracture {

/// glTF's bufferView targets.
inline constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;

class BufferContents {
 public:
  struct View {
    int stride = 0;  ///< 0 for indices and images
    int target = 0;  ///< 0 for images
    std::size_t size = 0;
  };

  /// Reserves memory for this many arrays at once, because reallocating millions of entries would be slow.
  void expect(std::size_t arrays) { pieces_.reserve(arrays); }

  /// Returns the index of the view with this name. Adds the view if it does not exist yet.
  std::size_t view(const std::string& name, int stride, int target) {
    const auto [at, fresh] = number_.try_emplace(name, views_.size());
    if (fresh) views_.push_back({stride, target});
    return at->second;
  }

  /// Appends `bytes` bytes to the view, which kWrite(source, out, pacer) will write later. They begin at a multiple of four, or
  /// with `next` directly after the previous ones. Returns their offset in the view. `source` is borrowed until write().
  template <auto kWrite, class Source>
  std::size_t put(std::size_t view, std::size_t bytes, const Source& source, bool next = false) {
    const std::size_t at = next ? views_[view].size : aligned(views_[view].size);
    views_[view].size = at + bytes;
    pieces_.push_back(
        {view, at, bytes, &source, [](const void* of, std::span<std::uint8_t> out, Pacer& pacer) {
           kWrite(*static_cast<const Source*>(of), out, pacer);
         }});
    return at;
  }

  const std::vector<View>& views() const { return views_; }
  /// Size of the buffer in bytes: all views in order, each beginning at a multiple of four.
  std::size_t size() const;
  /// Writes all arrays. `buffer` must contain size() zeros. Throws Interrupted.
  void write(std::uint8_t* buffer, const Execution& execution) const;

  static std::size_t aligned(std::size_t size) { return (size + 3) / 4 * 4; }

 private:
  struct Piece {
    std::size_t view, at, bytes;
    const void* source;
    void (*write)(const void* source, std::span<std::uint8_t> out, Pacer& pacer);
  };

  std::map<std::string, std::size_t> number_;  // index of each view
  std::vector<View> views_;
  std::vector<Piece> pieces_;
};

}  // namespace fracture
