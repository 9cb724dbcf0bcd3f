// Deterministic random numbers. The standard library's distributions and std::shuffle differ between
// implementations, so everything that reaches the output uses these instead (invariant I4).
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace fracture {

/// 2^64 divided by the golden ratio, made odd. Its multiples are spread evenly.
inline constexpr std::uint64_t kGoldenGamma = 0x9e3779b97f4a7c15ull;

/// The finalizer of SplitMix64 (below): a permutation in which every output bit depends on every input bit.
constexpr std::uint64_t mix64(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}
/// Extends the hash h of a sequence by v.
constexpr std::uint64_t mix64(std::uint64_t h, std::uint64_t v) { return mix64(h ^ v) + kGoldenGamma; }

/// SplitMix64 (Steele, Lea & Flood 2014, "Fast splittable pseudorandom number generators"). It has 64 bits of
/// state and passes BigCrush, and every seed is good. Draw into named variables, because f(rng(), rng()) has
/// no specified order.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t operator()() { return mix64(state_ += kGoldenGamma); }
  /// Uniform in [0, bound), bound > 0 (Lemire 2019, multiply-shift with rejection: unbiased).
  std::uint64_t below(std::uint64_t bound) {
    using u128 = unsigned __int128;
    u128 m = static_cast<u128>((*this)()) * bound;
    if (static_cast<std::uint64_t>(m) < bound) {
      const std::uint64_t threshold = (0 - bound) % bound;
      while (static_cast<std::uint64_t>(m) < threshold) m = static_cast<u128>((*this)()) * bound;
    }
    return static_cast<std::uint64_t>(m >> 64);
  }
  /// Uniform in [0, 1), a multiple of 2^-53.
  double uniform() { return static_cast<double>((*this)() >> 11) * 0x1.0p-53; }

 private:
  std::uint64_t state_;
};

/// Shuffles by Fisher–Yates.
template <class T>
void shuffle(std::vector<T>& items, Random& random) {
  for (std::size_t i = items.size(); i > 1; --i) {
    const std::size_t j = random.below(i);
    std::swap(items[i - 1], items[j]);
  }
}

}  // namespace fracture
