// Where a file goes while it is written: block by block, so that none is held whole.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>

namespace fracture::outputs {

/// Takes the next bytes of a file. False: no more are wanted (a disk is full, a stop came), which whoever gave it knows
/// the reason of.
using Sink = std::function<bool(std::string_view)>;

/// Gathers small writes to blocks.
class Blocks {
 public:
  explicit Blocks(const Sink& sink) : sink_(sink) { block_.reserve(kBlock + 256); }

  /// False as soon as the sink wants no more; what is written then goes nowhere.
  bool good() const { return good_; }

  Blocks& text(std::string_view text) {
    block_ += text;
    if (block_.size() >= kBlock) flush();
    return *this;
  }
  /// In decimal, the fewest digits that read back as the same number, in no language's manner.
  template <class Number>
  Blocks& number(Number number) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, number);
    return text({digits, static_cast<std::size_t>(end.ptr - digits)});
  }
  /// As memory has it, which is little-endian on all machines that this runs on (gltf/vertex_data.cpp asserts it).
  template <class Value>
  Blocks& raw(const Value& value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    return text({bytes, sizeof bytes});
  }
  /// Was all of it taken?
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
