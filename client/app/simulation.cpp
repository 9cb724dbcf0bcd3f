#include "client/app/simulation.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "client/app/sound_track.hpp"

namespace fracture::app {

Simulation::Simulation(std::unique_ptr<game::Game> game, std::uint64_t debris_seed)
    : game_(std::move(game)),
      step_length_(game_->world().settings().step),
      debris_(debris_seed),
      shown_debris_(std::make_shared<const effects::Debris>(debris_)),
      playing_again_(game_->settings().replay != nullptr) {
  publish();
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

Simulation::~Simulation() { halt(); }

void Simulation::pass(const Tick& tick) {
  {
    const std::lock_guard lock(mutex_);
    tick_ = tick;
    visited_ = true;
    if (!tick.running || playing_again_) {
      owed_ = 0;
    } else {
      owed_ += tick.seconds;
      const double most = kMostOwed * step_length_;
      dropped_ += std::max(0.0, owed_ - most);
      owed_ = std::min(owed_, most);
    }
  }
  wake_.notify_one();
}

void Simulation::step_once() {
  {
    const std::lock_guard lock(mutex_);
    ++singles_;
  }
  wake_.notify_one();
}

void Simulation::post(Command command) {
  if (halted_) {
    command(*game_);
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    commands_.push_back(std::move(command));
  }
  wake_.notify_one();
}

std::vector<std::shared_ptr<const Snapshot>> Simulation::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(published_, {});
}

void Simulation::halt() {
  if (std::exchange(halted_, true)) return;
  thread_.request_stop();
  thread_.join();
  for (const Command& command : std::exchange(commands_, {})) command(*game_);
}

// -- the simulation's thread

void Simulation::run(const std::stop_token& stop) {
  if (game_->settings().replay) play_again(stop);
  while (std::optional<Work> work = next(stop)) carry_out(std::move(*work));
}

void Simulation::play_again(const std::stop_token& stop) {
  constexpr std::chrono::milliseconds kPoll(1);
  while (!game_->replayed() && !game_->figures().diverged) {
    if (stop.stop_requested()) return;
    if (game_->ready()) {
      step();
      voices_.clear();  // sounds of the past are not played
    } else {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, stop, kPoll, [] { return false; });
    }
    if (asked_for()) publish();
  }
  game_->hand_over();
  {
    const std::lock_guard lock(mutex_);
    playing_again_ = false;
  }
  publish();
}

std::optional<Simulation::Work> Simulation::next(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  wake_.wait(lock, stop, [this] {
    return !commands_.empty() || singles_ > 0 || owed_ >= step_length_ || (visited_ && !tick_.running);
  });
  if (stop.stop_requested()) return std::nullopt;
  Work work{std::exchange(commands_, {}), tick_.eye, true};
  if (singles_ > 0)
    --singles_;
  else if (owed_ >= step_length_)
    owed_ -= step_length_;
  else
    work.step = false;
  if (work.step) due_ += std::exchange(dropped_, 0);
  return work;
}

void Simulation::carry_out(Work work) {
  game_->set_eye(work.eye);
  for (const Command& command : work.commands)
    if (std::string note = command(*game_); !note.empty()) notes_.push_back(std::move(note));
  const bool swapped = game_->attend();
  // Publishes the new pieces at the time and place of the whole. So both snapshots between which a frame is
  // drawn contain the same things.
  if (swapped || !work.commands.empty() || !work.step) publish();
  if (!work.step) return;
  step();
  due_ += step_length_;
  publish();
}

void Simulation::step() {
  const auto begin = std::chrono::steady_clock::now();
  game_->step();
  const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - begin;
  step_ms_ = spent.count();
  const world::Witnessed witnessed = game_->take_witnessed();
  debris_.follow(game_->world(), witnessed, materials_of(*game_));
  shown_debris_ = nullptr;
  for (sound::Voice& voice : soundscape_.voices(witnessed, materials_of(*game_)))
    voices_.push_back(std::move(voice));
}

void Simulation::publish() {
  constexpr unsigned kCensusEvery = 12;  // snapshots
  bool loads = false;
  {
    const std::lock_guard lock(mutex_);
    loads = tick_.loads;
    visited_ = false;
  }
  if (published_count_++ % kCensusEvery == 0) census_ = game_->world().census();
  if (!patterns_ && !game_->patterns().empty())
    patterns_ = std::make_shared<const std::string>(game_->patterns());
  if (!shown_debris_) shown_debris_ = std::make_shared<const effects::Debris>(debris_);
  const game::GameSettings& settings = game_->settings();
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->due = due_;
  snapshot->moment = std::make_shared<const game::Moment>(game::moment_of(*game_, loads));
  snapshot->debris = shown_debris_;
  snapshot->coming = game_->coming();
  snapshot->voices = std::exchange(voices_, {});
  snapshot->notes = std::exchange(notes_, {});
  snapshot->figures = game_->figures();
  snapshot->census = census_;
  snapshot->ledger = game_->world().ledger();
  snapshot->step_ms = step_ms_;
  snapshot->last_glb = game_->last_glb();
  snapshot->patterns = patterns_;
  snapshot->history_full = settings.history && settings.history->full();
  if (settings.replay)
    snapshot->played_again_percent = static_cast<int>(
        settings.replay->hashes.empty() ? 100
                                        : 100 * game_->world().steps() / settings.replay->hashes.size());
  const std::lock_guard lock(mutex_);
  published_.push_back(std::move(snapshot));
}

bool Simulation::asked_for() {
  const std::lock_guard lock(mutex_);
  return visited_;
}

}  // namespace fracture::app
