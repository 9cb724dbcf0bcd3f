// Plays clips through OpenAL Soft. Each clip has a position, and so does the listener. The sound goes to the
// machine's device or into memory (ALC_SOFT_loopback), which needs no device and is independent of real time.
//
// OpenAL has one current context per process, so create only one Speakers at a time and call it from one
// thread.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <span>

#include "client/sound/clip.hpp"
#include "common/base/error.hpp"

namespace fracture::sound {

class Speakers {
 public:
  /// Maximum number of simultaneous voices; beyond it, the faintest is stopped.
  static constexpr std::size_t kVoices = 32;

  /// May take seconds if a sound server must be found. kNoSound.
  static Expected<Speakers> device();
  /// Renders stereo in 32-bit floats at kRate. kNoSound.
  static Expected<Speakers> loopback();
  Speakers(Speakers&&) noexcept;
  ~Speakers();

  /// `gain`: 0 … 1, the amplitude within three metres. Beyond that, it falls with the distance (6 dB per
  /// doubling).
  void play(const Clip& clip, const glm::dvec3& where, double gain);
  void listen(const glm::dvec3& eye, const glm::dvec3& forward);
  void set_volume(double volume);  ///< 0 … 1
  /// Loopback only: renders the next samples.size() / 2 frames, left and right interleaved.
  void render(std::span<float> samples);

 private:
  struct State;
  explicit Speakers(std::unique_ptr<State> state);
  static Expected<Speakers> start(std::unique_ptr<State> state, const int* attributes);
  std::unique_ptr<State> state_;
};

}  // namespace fracture::sound
