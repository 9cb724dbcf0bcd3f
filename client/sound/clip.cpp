#include "client/sound/clip.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fracture::sound {
namespace {

using std::numbers::pi;

constexpr double kLongest = 1.5;       // seconds
constexpr double kSilent = 6.9;        // nepers: 60 dB below the start
constexpr int kFadeOut = kRate / 100;  // samples

/// Spectrum of a half-sine with unit area and length t at a frequency: |cos(π f t) / (1 − 4 f² t²)|; π/4 if
/// both parts vanish.
double spectrum(double frequency, double t) {
  const double x = 2 * frequency * t;
  if (std::abs(x - 1) < 1e-6) return pi / 4;
  return std::abs(std::cos(0.5 * pi * x) / (1 - x * x));
}

}  // namespace

double loudest(std::span<const Mode> modes, double impulse, double contact) {
  double sum = 0;
  for (const Mode& mode : modes) sum += std::abs(mode.pressure) * impulse * spectrum(mode.frequency, contact);
  return sum;
}

Clip strike(std::span<const Mode> modes, double impulse, double contact) {
  Clip clip;
  double longest = 0;
  for (const Mode& mode : modes) longest = std::max(longest, kSilent / mode.decay);
  const auto count = static_cast<std::size_t>(std::min(longest, kLongest) * kRate);
  if (count == 0) return clip;
  std::vector<double> sum(count, 0.0);
  for (const Mode& mode : modes) {
    // y[k] = 2 r cos ω y[k−1] − r² y[k−2], which is r^k sin(ω k) from y[0] = 0, y[1] = r sin ω.
    const double amplitude = mode.pressure * impulse * spectrum(mode.frequency, contact);
    const double omega = 2 * pi * mode.frequency / kRate, r = std::exp(-mode.decay / kRate);
    const double first = 2 * r * std::cos(omega), second = r * r;
    const std::size_t end = std::min(count, static_cast<std::size_t>(kSilent / mode.decay * kRate) + 1);
    double before = 0, now = amplitude * r * std::sin(omega);
    for (std::size_t k = 1; k < end; ++k) {
      sum[k] += now;
      const double next = first * now - second * before;
      before = now;
      now = next;
    }
  }
  for (const double x : sum) clip.pressure = std::max(clip.pressure, std::abs(x));
  if (!(clip.pressure > 0)) return Clip{};
  clip.samples.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    const double left = std::min(1.0, static_cast<double>(count - 1 - k) / kFadeOut);
    clip.samples.push_back(static_cast<float>(left * sum[k] / clip.pressure));
  }
  return clip;
}

}  // namespace fracture::sound
