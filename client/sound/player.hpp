// Plays sound for a game that must not wait: a separate thread makes clips and calls OpenAL. If there is no
// device, the state says so.
#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <string>
#include <thread>

#include "client/sound/soundscape.hpp"

namespace fracture::sound {

class Player {
 public:
  enum class State { kStarting, kPlaying, kNoDevice };

  Player();
  ~Player();  ///< waits for the clip that is being made

  /// Passes a frame's voices and the listener's position. Takes no longer than a lock. If more than
  /// kMostWaiting voices are waiting for the thread, the oldest are dropped.
  void hear(std::vector<Voice> voices, const glm::dvec3& eye, const glm::dvec3& forward);
  void set_volume(double volume);  ///< 0 … 1
  State state() const;

  static constexpr std::size_t kMostWaiting = 24;

 private:
  void run();

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Voice> waiting_;
  glm::dvec3 eye_{0}, forward_{0, 0, -1};
  double volume_ = 1;
  bool moved_ = false, end_ = false;
  State state_ = State::kStarting;
  std::thread thread_;  // last, because it uses the others
};

}  // namespace fracture::sound
