// The sound of a struck body, as samples.
#pragma once

#include <span>
#include <vector>

#include "client/sound/modes.hpp"

namespace fracture::sound {

inline constexpr int kRate = 48000;  ///< samples per second: 400 for each step of the game

/// A voice, with its loudness separate from its samples.
struct Clip {
  std::vector<float> samples;  ///< mono; the largest magnitude is 1; empty: inaudible
  double pressure = 0;         ///< Pa: the pressure at a distance of 1 m that a sample of 1 stands for
};

/// An impulse (N·s) that lasts `contact` seconds excites these modes. The result is a sum of damped sines,
/// each as strong as its frequency is in the force's half-sine (soft and slow contacts sound dull). At most
/// 1.5 s; fades out at the end.
Clip strike(std::span<const Mode> modes, double impulse, double contact);

/// An upper bound on the pressure of strike(), without computing samples.
double loudest(std::span<const Mode> modes, double impulse, double contact);

}  // namespace fracture::sound
