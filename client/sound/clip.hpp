// A struck body as samples.
#pragma once

#include <span>
#include <vector>

#include "client/sound/modes.hpp"

namespace fracture::sound {

inline constexpr int kRate = 48000;  ///< samples a second: 400 for each step of the game

/// One voice, and where its loudness is kept.
struct Clip {
  std::vector<float> samples;  ///< mono, the largest is 1 or -1; empty: nothing is heard
  double pressure = 0;         ///< Pa at one metre that the largest stands for
};

/// An impulse (N·s) that lasts `contact` seconds, on these modes: the sum of damped sines, each as strong as the half-sine
/// of the force has its frequency (soft and slow contacts are dull). At most 1.5 s; ends without a step.
Clip strike(std::span<const Mode> modes, double impulse, double contact);

/// The pressure that strike() would come to, at most, without making the samples.
double loudest(std::span<const Mode> modes, double impulse, double contact);

}  // namespace fracture::sound
