// The cost of a picture. Low: two cores can draw it without a graphics card. High: it needs a graphics card
// (client/README.md lists its features). Auto: high if the card is fast enough.
#pragma once

#include <array>
#include <string_view>

namespace fracture::render {

enum class Tier { kLow, kHigh };
enum class TierWish { kLow, kHigh, kAuto };
inline constexpr std::array<const char*, 3> kTierWishNames = {"low", "high", "auto"};

/// Chooses the tier of the next picture only from the times of the previous pictures. It goes down if most
/// pictures of half a second were too slow. It goes up only if low pictures leave room for several high ones.
/// After a wrong attempt it waits longer before the next one, and after two wrong attempts it stays low.
class TierChoice {
 public:
  /// With software rendering it is always low, whatever the times are.
  explicit TierChoice(bool software = false) : software_(software) {}
  Tier tier() const { return tier_; }
  /// A picture of tier() took this many milliseconds on the card.
  void add(double milliseconds);

 private:
  bool software_;
  Tier tier_ = Tier::kLow;
  int to_skip_ = 0;  ///< a new tier's first pictures do not count: they compile shaders
  int pictures_ = 0, slow_ = 0, fast_ = 0;  ///< in the current series
  int roomy_ = 0;                           ///< number of consecutive series with room for the high tier
  int falls_ = 0;
};

/// Whether a driver with this name (GL_RENDERER) draws without a graphics card.
bool draws_in_software(std::string_view renderer);

}  // namespace fracture::render
