// The values of a PLY file's data, one after the other: the same interface for text and binary. Both throw Refused.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/import/binary_numbers.hpp"
#include "common/import/ply_header.hpp"
#include "common/import/refused.hpp"
#include "common/import/text_scanner.hpp"

namespace fracture {

/// Each instance of an element begins on a new line. More values on its last line are ignored.
class PlyTextData {
 public:
  PlyTextData(std::string_view file, const PlyHeader& header) : scan_(file, "PLY", false) {
    scan_.seek(header.end);
  }

  /// Begins an instance, and returns its place.
  std::size_t begin() {
    scan_.find_word();
    return scan_.at();
  }
  void end() { scan_.skip_line(); }
  double number(PlyType) { return scan_.number("a value"); }
  std::uint64_t length(PlyType, PlyType) {
    const std::uint64_t count = scan_.count("the length of a list");
    if (count > scan_.remaining() / 2 + 1)  // a digit and a blank each
      refuse(ErrorCode::kMalformedMesh, "The PLY has a list of " + std::to_string(count) + " values at " +
                                            scan_.place(scan_.at()) + ", but only " +
                                            std::to_string(scan_.remaining()) +
                                            " bytes follow. Export or copy the file again.");
    return count;
  }
  void skip(PlyType, std::uint64_t count) {
    for (std::uint64_t k = 0; k < count; ++k) scan_.skip_word("a value");
  }

 private:
  TextScanner scan_;
};

class PlyBinaryData {
 public:
  PlyBinaryData(std::span<const std::byte> file, const PlyHeader& header)
      : file_(file),
        order_(header.encoding == PlyEncoding::kBigEndian ? ByteOrder::kBig : ByteOrder::kLittle),
        at_(header.end) {}

  std::size_t begin() const { return at_; }
  void end() {}

  double number(PlyType type) {
    const std::size_t size = ply_bytes(type);
    require(size);
    const std::uint64_t raw = unsigned_at(file_, at_, size, order_);
    at_ += size;
    switch (type) {
      case PlyType::kInt8:
        return static_cast<std::int8_t>(raw);
      case PlyType::kInt16:
        return static_cast<std::int16_t>(raw);
      case PlyType::kInt32:
        return static_cast<std::int32_t>(raw);
      case PlyType::kFloat:
        return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(raw)));
      case PlyType::kDouble:
        return std::bit_cast<double>(raw);
      default:
        return static_cast<double>(raw);
    }
  }

  /// Reads the length of a list, and checks that its values of type `of` follow.
  std::uint64_t length(PlyType type, PlyType of) {
    const std::size_t at = at_;
    const double value = number(type);
    if (value < 0)
      refuse(ErrorCode::kMalformedMesh, "The PLY has a list of negative length at byte " +
                                            std::to_string(at) + ". Export the file again.");
    const auto count = static_cast<std::uint64_t>(value);
    require(count * ply_bytes(of));
    return count;
  }

  void skip(PlyType type, std::uint64_t count) {
    const std::uint64_t size = count * ply_bytes(type);
    require(size);
    at_ += size;
  }

 private:
  void require(std::uint64_t size) const {
    if (size <= file_.size() - at_) return;
    refuse(ErrorCode::kMalformedMesh, "The PLY has " + std::to_string(file_.size()) +
                                          " bytes, but the value or list at byte " + std::to_string(at_) +
                                          " needs " + std::to_string(size) +
                                          " more. It was cut short: export or copy it again.");
  }

  std::span<const std::byte> file_;
  ByteOrder order_;
  std::size_t at_;
};

}  // namespace fracture
