// What will lie in the buffer of the file: bufferViews, and which array of which mesh is written where in them. The text of
// the file stands before its buffer and says only how large everything is; so that is settled first, and then each array is
// written where it will stay, on all threads.
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

  /// Makes room for so many arrays at once: there may be millions, and none moves while they become more.
  void expect(std::size_t arrays) { pieces_.reserve(arrays); }

  /// The view of this name; made where there is none.
  std::size_t view(const std::string& name, int stride, int target) {
    const auto [at, fresh] = number_.try_emplace(name, views_.size());
    if (fresh) views_.push_back({stride, target});
    return at->second;
  }

  /// The next `bytes` bytes of the view, from a multiple of four on or (`next`) right behind the last ones: kWrite(source,
  /// out, pacer) will write them. Returns where in the view they are. The source is borrowed until write().
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
  /// Of the buffer: its views one after the other, each from a multiple of four on.
  std::size_t size() const;
  /// `buffer`: size() zeros. Throws Interrupted.
  void write(std::uint8_t* buffer, const Execution& execution) const;

  static std::size_t aligned(std::size_t size) { return (size + 3) / 4 * 4; }

 private:
  struct Piece {
    std::size_t view, at, bytes;
    const void* source;
    void (*write)(const void* source, std::span<std::uint8_t> out, Pacer& pacer);
  };

  std::map<std::string, std::size_t> number_;  // of views
  std::vector<View> views_;
  std::vector<Piece> pieces_;
};

}  // namespace fracture
