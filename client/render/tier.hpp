// How much a picture may cost. Low: what two cores draw without a graphics card. High: what takes one (client/README.md
// lists what it has). Auto: high where a card has room for it.
#pragma once

#include <array>
#include <string_view>

namespace fracture::render {

enum class Tier { kLow, kHigh };
enum class TierWish { kLow, kHigh, kAuto };
inline constexpr std::array<const char*, 3> kTierWishNames = {"low", "high", "auto"};

/// Chooses the tier of the next picture by what those before took; a function of these times alone. Down once most of half
/// a second's pictures are too slow; up only where pictures of the low tier leave room for several of them, and after each time
/// that this was wrong only after a longer while: twice, then never again.
class TierChoice {
 public:
  /// In software it is low, whatever pictures take.
  explicit TierChoice(bool software = false) : software_(software) {}
  Tier tier() const { return tier_; }
  /// A picture of tier() took so many milliseconds of the card.
  void add(double milliseconds);

 private:
  bool software_;
  Tier tier_ = Tier::kLow;
  int to_skip_ = 0;  ///< of a new tier the first are no measure: shaders are compiled, memory is asked for
  int pictures_ = 0, slow_ = 0, fast_ = 0;  ///< of the series that runs
  int roomy_ = 0;                           ///< series in a row with room for the high tier
  int falls_ = 0;
};

/// Does a driver of this name (GL_RENDERER) draw without a graphics card?
bool draws_in_software(std::string_view renderer);

}  // namespace fracture::render
