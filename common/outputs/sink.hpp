// Destination of a file that is written block by block, so that the whole file is never in memory.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>

namespace fracture::outputs {

/// Receives the next bytes of a file. Returns false if no more are wanted (a full disk or a stop request);
/// the function's creator knows the reason.
using Sink = std::function<bool(std::string_view)>;

/// Combines small writes into blocks.
class Blocks {
 public:
  explicit Blocks(const Sink& sink) : sink_(sink) { block_.reserve(kBlock + 256); }

  /// False once the sink wants no more data; further writes are discarded.
  bool good() const { return good_; }

  Blocks& text(std::string_view text) {
    block_ += text;
    if (block_.size() >= kBlock) flush();
    return *this;
  }
  /// Writes a number in decimal, with the fewest digits that read back as the same number, independent of the
  /// locale.
  template <class Number>
  Blocks& number(Number number) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, number);
    return text({digits, static_cast<std::size_t>(end.ptr - digits)});
  }
  /// Writes the bytes as in memory: little-endian on all supported machines (gltf/vertex_data.cpp asserts
  /// it).
  template <class Value>
  Blocks& raw(const Value& value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    return text({bytes, sizeof bytes});
  }
  /// Writes the remaining data. Returns whether all data was accepted.
  bool finish() {
    flush();
    return good_;
  }

 private:
  static constexpr std::size_t kBlock = std::size_t{1} << 18;

  void flush() {
    good_ = good_ && (block_.empty() || sink_(block_));
    block_.clear();
  }

  const Sink& sink_;
  std::string block_;
  bool good_ = true;
};

}  // namespace fracture::outputs
