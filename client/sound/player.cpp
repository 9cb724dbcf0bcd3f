#include "client/sound/player.hpp"

#include "client/sound/speakers.hpp"

namespace fracture::sound {

Player::Player() : thread_([this] { run(); }) {}

Player::~Player() {
  {
    const std::lock_guard lock(mutex_);
    end_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void Player::hear(std::vector<Voice> voices, const glm::dvec3& eye, const glm::dvec3& forward) {
  {
    const std::lock_guard lock(mutex_);
    moved_ = true;
    eye_ = eye;
    forward_ = forward;
    if (state_ == State::kNoDevice) return;
    for (Voice& voice : voices) {
      if (waiting_.size() >= kMostWaiting) waiting_.pop_front();
      waiting_.push_back(std::move(voice));
    }
  }
  wake_.notify_one();
}

void Player::set_volume(double volume) {
  {
    const std::lock_guard lock(mutex_);
    if (volume_ == volume) return;
    volume_ = volume;
    moved_ = true;
  }
  wake_.notify_one();
}

Player::State Player::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

void Player::run() {
  Expected<Speakers> speakers = Speakers::device();
  std::unique_lock lock(mutex_);
  state_ = speakers ? State::kPlaying : State::kNoDevice;
  waiting_.clear();  // voices from the time before the device was found
  if (!speakers) return;
  for (;;) {
    wake_.wait(lock, [this] { return end_ || moved_ || !waiting_.empty(); });
    if (end_) return;
    moved_ = false;
    const glm::dvec3 eye = eye_, forward = forward_;
    const double volume = volume_;
    std::deque<Voice> voices = std::move(waiting_);
    waiting_.clear();
    lock.unlock();
    speakers->listen(eye, forward);
    speakers->set_volume(volume);
    for (const Voice& voice : voices) {
      const Clip clip = strike(voice.modes, voice.impulse, voice.contact);
      speakers->play(clip, voice.where, amplitude_of(clip.pressure));
    }
    lock.lock();
  }
}

}  // namespace fracture::sound
