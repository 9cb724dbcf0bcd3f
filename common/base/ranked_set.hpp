// A set of numbers below n, in order, with the rank of each. It stores one bit per number and, for every 64
// bits, the count of members before them (Jacobson 1989, "Space-efficient static trees and graphs", in its
// simplest form).
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fracture {

class RankedSet {
 public:
  explicit RankedSet(std::size_t n) : words_(n / 64 + 1) {}

  /// Must be called before close().
  void add(std::uint32_t k) { words_[k / 64].bits |= bit(k); }
  bool contains(std::uint32_t k) const { return (words_[k / 64].bits & bit(k)) != 0; }
  /// Computes the counts. Linear in n / 64.
  void close() {
    count_ = 0;
    for (Word& word : words_) {
      word.before = count_;
      count_ += static_cast<std::uint32_t>(std::popcount(word.bits));
    }
  }
  // The following functions must be called after close().
  std::uint32_t size() const { return count_; }
  /// Number of members less than k.
  std::uint32_t rank(std::uint32_t k) const {
    const Word& word = words_[k / 64];
    return word.before + static_cast<std::uint32_t>(std::popcount(word.bits & (bit(k) - 1)));
  }
  /// Calls visit(k) for each member, in ascending order.
  template <class Visit>
  void each(const Visit& visit) const {
    for (std::size_t w = 0; w < words_.size(); ++w)
      for (std::uint64_t rest = words_[w].bits; rest != 0; rest &= rest - 1)
        visit(static_cast<std::uint32_t>(64 * w + static_cast<std::size_t>(std::countr_zero(rest))));
  }

 private:
  struct Word {
    std::uint64_t bits = 0;
    std::uint32_t before = 0;
  };
  static std::uint64_t bit(std::uint32_t k) { return std::uint64_t{1} << (k % 64); }

  std::vector<Word> words_;
  std::uint32_t count_ = 0;
};

}  // namespace fracture
