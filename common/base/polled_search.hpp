// Finds byte sequences in large files, in linear time and with polls.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"

namespace fracture {

/// Finds the places of a sequence in a text, in their order. The text, the sequence and the execution are borrowed.
///
/// Horspool, "Practical fast searching in strings", Software: Practice and Experience 10 (1980): compares the last byte of the
/// sequence first, and moves by up to its length. Each byte costs at most one comparison with the sequence, which is short.
/// A search for the first byte alone is slow if that byte fills the text.
class PolledSearch {
 public:
  static constexpr std::size_t kNone = std::string_view::npos;

  /// `wanted`: 1 to 255 bytes.
  PolledSearch(std::string_view text, std::string_view wanted, const Execution& execution)
      : text_(text), wanted_(wanted), execution_(execution) {
    const auto size = static_cast<std::uint8_t>(wanted.size());
    step_.fill(size);
    for (std::uint8_t k = 0; k + 1 < size; ++k)
      step_[static_cast<unsigned char>(wanted[k])] = static_cast<std::uint8_t>(size - 1 - k);
  }

  /// Returns the first place in [from, end) where the sequence begins; kNone if there is none. Polls once per
  /// kBytesBetweenPolls, over all calls. Throws Interrupted.
  std::size_t find(std::size_t from, std::size_t end = kNone) {
    if (text_.size() < wanted_.size()) return kNone;
    end = std::min(end, text_.size() - wanted_.size() + 1);
    while (from < end) {
      if (from >= next_poll_) {
        execution_.poll();
        next_poll_ = from + kBytesBetweenPolls;
      }
      for (const std::size_t stop = std::min(end, next_poll_); from < stop;) {
        const char last = text_[from + wanted_.size() - 1];
        if (last == wanted_.back() && text_[from] == wanted_.front() &&
            std::memcmp(text_.data() + from, wanted_.data(), wanted_.size()) == 0)
          return from;
        from += step_[static_cast<unsigned char>(last)];
      }
    }
    return kNone;
  }

 private:
  const std::string_view text_, wanted_;
  const Execution& execution_;
  std::array<std::uint8_t, 256> step_{};  ///< by the text's byte at the end of the sequence: how far to move
  std::size_t next_poll_ = 0;
};

}  // namespace fracture
