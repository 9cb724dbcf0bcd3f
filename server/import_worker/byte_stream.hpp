// Numbers, texts and arrays of plain values as a flat sequence of bytes in the machine's own byte order. It is for two
// processes of the same program on the same machine. The reader trusts nothing: it checks every length against the available
// bytes before it allocates memory, and polls between copies. After the first failure, all further reads fail.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/base/pacer.hpp"

namespace fracture {

class ByteWriter {
 public:
  void reserve(std::size_t bytes) { bytes_.reserve(bytes); }
  template <class T>
  void value(T v) {
    static_assert(std::is_trivially_copyable_v<T>);
    append(&v, sizeof v);
  }
  void text(std::string_view s) {
    value<std::uint64_t>(s.size());
    append(s.data(), s.size());
  }
  template <class T>
  void array(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    value<std::uint64_t>(values.size());
    append(values.data(), values.size() * sizeof(T));
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void append(const void* data, std::size_t size) {
    const auto* begin = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), begin, begin + size);
  }
  std::vector<std::byte> bytes_;
};

class ByteReader {
 public:
  /// `execution`: borrowed. The functions that return texts and arrays throw Interrupted.
  explicit ByteReader(std::span<const std::byte> bytes, const Execution& execution = kUninterrupted)
      : bytes_(bytes), execution_(execution), pacer_(execution) {}

  template <class T>
  T value() {
    static_assert(std::is_trivially_copyable_v<T>);
    T v{};
    take(&v, sizeof v);
    return v;
  }
  /// Counts as the work to parse it too, because most texts are parsed next.
  std::string text() {
    const std::uint64_t size = length(1);
    pacer_.step(8 + size / 8);
    std::string s(static_cast<std::size_t>(size), '\0');
    take(s.data(), s.size());
    return s;
  }
  template <class T>
  std::vector<T> array() {
    static_assert(std::is_trivially_copyable_v<T>);
    constexpr std::size_t kAtOnce = kBytesBetweenPolls / sizeof(T);
    const auto count = static_cast<std::size_t>(length(sizeof(T)));
    std::vector<T> values;
    values.reserve(count);
    while (values.size() < count) {
      execution_.poll();
      const std::size_t begin = values.size(), more = std::min(count - begin, kAtOnce);
      values.resize(begin + more);
      take(values.data() + begin, more * sizeof(T));
    }
    return values;
  }
  /// Returns a view of the next `size` bytes. Fails and returns an empty view if there are fewer.
  std::span<const std::byte> view(std::uint64_t size) {
    if (size > bytes_.size()) return fail(), std::span<const std::byte>();
    const auto found = bytes_.first(static_cast<std::size_t>(size));
    bytes_ = bytes_.subspan(found.size());
    return found;
  }
  /// Reads the number of items that follow, each with at least `item_bytes`. Fails and returns 0 if the rest is too short.
  std::uint64_t length(std::size_t item_bytes) {
    const auto count = value<std::uint64_t>();
    if (count <= bytes_.size() / item_bytes) return count;
    fail();
    return 0;
  }
  bool good() const { return good_; }
  const Execution& execution() const { return execution_; }
  std::size_t left() const { return bytes_.size(); }
  bool at_end() const { return good_ && bytes_.empty(); }

 private:
  void take(void* to, std::size_t size) {
    if (size > bytes_.size()) return fail();
    if (size > 0) std::memcpy(to, bytes_.data(), size);
    bytes_ = bytes_.subspan(size);
  }
  void fail() {
    good_ = false;
    bytes_ = {};
  }
  std::span<const std::byte> bytes_;
  const Execution& execution_;
  Pacer pacer_;
  bool good_ = true;
};

}  // namespace fracture
