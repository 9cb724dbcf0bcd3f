#include "client/render/tier.hpp"

#include <algorithm>
#include <cctype>
#include <string>

namespace fracture::render {

void TierChoice::add(double milliseconds) {
  if (software_) return;
  constexpr int kSeries = 30, kSkipped = 10;
  constexpr double kTooSlow = 25;  // fewer than 40 pictures per second
  constexpr double kRoom = 3;      // the high tier takes up to eight times as long as the low one
  constexpr int kMostSlow = 20, kLeastFast = 29, kFirstRoom = 2, kLonger = 8, kMostFalls = 2;
  if (to_skip_ > 0) {
    --to_skip_;
    return;
  }
  slow_ += milliseconds > kTooSlow;
  fast_ += milliseconds < kRoom;
  if (++pictures_ < kSeries) return;
  const bool slow = slow_ >= kMostSlow, roomy = fast_ >= kLeastFast;
  pictures_ = slow_ = fast_ = 0;
  roomy_ = roomy ? roomy_ + 1 : 0;
  const Tier before = tier_;
  if (tier_ == Tier::kHigh && slow) {
    tier_ = Tier::kLow;
    ++falls_;
  } else if (tier_ == Tier::kLow && falls_ < kMostFalls) {
    int needed = kFirstRoom;
    for (int k = 0; k < falls_; ++k) needed *= kLonger;
    if (roomy_ >= needed) tier_ = Tier::kHigh;
  }
  if (tier_ == before) return;
  to_skip_ = kSkipped;
  roomy_ = 0;
}

bool draws_in_software(std::string_view renderer) {
  std::string name(renderer);
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr std::string_view kKnown[] = {"llvmpipe",    "softpipe", "swrast",
                                         "swiftshader", "software", "basic render"};
  return std::any_of(std::begin(kKnown), std::end(kKnown),
                     [&](std::string_view known) { return name.find(known) != std::string::npos; });
}

}  // namespace fracture::render
