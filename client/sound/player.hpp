// Sound beside a game that must not wait: a thread of its own makes clips and talks to OpenAL. Where there is no device
// it is silent, and says so.
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

  /// What a frame brings, and from where it is heard. Takes as long as a lock; the oldest voices are dropped where the
  /// thread falls behind by more than kMostWaiting.
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
  std::thread thread_;  // last: it uses the others
};

}  // namespace fracture::sound
