// OpenAL Soft: clips at places, heard from another place. It plays on the machine's device, or renders what would be
// played into memory (ALC_SOFT_loopback), which needs no device and takes as long as it takes.
//
// OpenAL has one current context in a process: only one of these at a time, and all calls from one thread.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <span>

#include "client/sound/clip.hpp"
#include "common/base/error.hpp"

namespace fracture::sound {

class Speakers {
 public:
  /// Voices at the same time; beyond it the faintest goes.
  static constexpr std::size_t kVoices = 32;

  /// May take seconds where a sound server has to be found. kNoSound.
  static Expected<Speakers> device();
  /// Stereo in 32-bit floats at kRate. kNoSound.
  static Expected<Speakers> loopback();
  Speakers(Speakers&&) noexcept;
  ~Speakers();

  /// `gain`: 0 … 1, the amplitude within three metres; beyond it falls with the distance (6 dB for twice of it).
  void play(const Clip& clip, const glm::dvec3& where, double gain);
  void listen(const glm::dvec3& eye, const glm::dvec3& forward);
  void set_volume(double volume);  ///< 0 … 1
  /// Loopback: the next samples.size() / 2 frames, left and right in turn.
  void render(std::span<float> samples);

 private:
  struct State;
  explicit Speakers(std::unique_ptr<State> state);
  static Expected<Speakers> start(std::unique_ptr<State> state, const int* attributes);
  std::unique_ptr<State> state_;
};

}  // namespace fracture::sound
