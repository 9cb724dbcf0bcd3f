#include "client/app/headless.hpp"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <thread>

#include "client/app/game_summary.hpp"
#include "client/app/picture_taker.hpp"
#include "client/app/players.hpp"
#include "client/app/recorded_options.hpp"
#include "client/app/sound_track.hpp"
#include "client/film/film.hpp"
#include "common/base/printable.hpp"

namespace fracture::app {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr int kStepsPerFrame = 2;  // 120 steps and 60 frames per second

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Processor time of the calling thread only, so other work on the machine does not count.
double processor_milliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

game::GameSettings settings_of(const Options& options) {
  game::GameSettings settings;
  settings.seed = options.seed;
  settings.anticipate = options.anticipate;
  settings.overrides = options.parameters;
  if (options.fixed_step) settings.fixed_latency = options.answer_steps;
  if (!options.requests) settings.max_requests = 0;
  const bool drawn = options.draw || !options.record.empty() || !options.screenshots.empty();
  if (!options.wav.empty() || (drawn && options.effects)) settings.world.max_witnessed = kMostWitnessed;
  return settings;
}

/// A game without a window, from its first frame to the summary.
class HeadlessRun {
 public:
  HeadlessRun(const Options& options, scenes::Scene scene, game::GameSettings settings, Players players)
      : options_(options),
        client_(options.server),
        settings_(std::move(settings)),
        players_(std::move(players)),
        game_(std::move(scene), client_, settings_),
        picture_taker_(options),
        debris_(options.seed),
        screenshots_(options.screenshots),
        frame_length_(kStepsPerFrame * settings_.world.step) {
    std::sort(screenshots_.begin(), screenshots_.end());
    if (players_.link)
      lockstep_.emplace(game_, *players_.link, players_.seat, players_.header, players_.theirs);
  }

  Expected<json> run() {
    if (options_.draw)  // compiles shaders and uploads the scene, so that no frame pays for it
      if (const auto drawn = picture_taker_.draw(game_, debris()); !drawn)
        return tl::unexpected(drawn.error());
    if (!options_.wav.empty()) {
      Expected<SoundTrack> track = SoundTrack::create(options_.wav, game_.scene());
      if (!track) return tl::unexpected(track.error());
      sound_.emplace(std::move(*track));
    }
    if (!options_.record.empty()) {
      Expected<film::Film> made =
          film::Film::create(options_.record, {.width = options_.width, .height = options_.height});
      if (!made) return tl::unexpected(made.error());
      film_.emplace(std::move(*made));
    }
    Expected<void> first = play();
    if (first && lockstep_) first = wait_until([this] { return lockstep_->level(); });
    if (!first && lockstep_) lockstep_->leave(first.error().detail);
    const bool played = first.has_value();
    // The sound and the recording are finished after any failure. An unfinished film is discarded.
    const auto keep = [&first](Expected<void> more) {
      if (first && !more) first = std::move(more);
    };
    if (sound_) keep(sound_->finish());
    if (settings_.recorder && !settings_.recorder->finish())
      keep(fail(ErrorCode::kFileAccess,
                "Cannot finish writing the recording " + options_.log + ". Is the disk full?"));
    if (film_ && played) keep(film_->finish());
    if (!first) return tl::unexpected(first.error());
    return result();
  }

 private:
  std::uint64_t frames() const {
    const std::uint64_t recorded =
        settings_.replay ? (settings_.replay->hashes.size() + kStepsPerFrame - 1) / kStepsPerFrame : 0;
    if (!options_.replay.empty()) return recorded;
    return std::max(recorded, static_cast<std::uint64_t>(std::llround(options_.seconds / frame_length_)));
  }
  bool replays() const { return game_.settings().replay != nullptr; }

  Expected<void> play() {
    start_ = Clock::now();
    const std::uint64_t frames = this->frames();
    for (std::uint64_t frame = 0; frame <= frames; ++frame) {
      const double now = static_cast<double>(frame) * frame_length_;
      // The end may be a fraction of a frame after the last frame.
      const double until = frame == frames ? std::max(now, options_.seconds) : now;
      if (auto taken = take_pictures(until); !taken) return tl::unexpected(taken.error());
      if (frame == frames) break;
      const std::uint64_t swaps_before = game_.figures().swaps;
      const Expected<double> stepped =
          options_.fixed_step || replays() ? step_at_fixed_pace() : Expected<double>(step_in_real_time(now));
      if (!stepped) return tl::unexpected(stepped.error());
      double spent = *stepped;
      if (!options_.continue_from.empty() && game_.figures().diverged)
        return fail(ErrorCode::kUnavailable, "Step " + std::to_string(*game_.figures().diverged) +
                                                 " differs from the recording in " + options_.continue_from +
                                                 ", so the game cannot be continued.");
      if (options_.draw) {
        const Expected<double> drawn = draw();
        if (!drawn) return tl::unexpected(drawn.error());
        spent += *drawn;
      }
      work_times_.push_back(std::exchange(work_, 0.0));
      times_.add(spent, game_.figures().swaps > swaps_before, game_.open_requests() > 0);
      fastest_ = std::max(fastest_, game_.world().census().fastest);
      tell_of_absence();
    }
    return {};
  }

  Expected<void> take_pictures(double now) {
    for (; next_picture_ < screenshots_.size() && screenshots_[next_picture_] <= now + kSameTime;
         ++next_picture_) {
      char file[64];
      std::snprintf(file, sizeof file, "%s-%.2f.png", game_.scene().name.c_str(),
                    screenshots_[next_picture_]);
      Expected<json> picture = picture_taker_.take(game_, debris(), file);
      if (!picture) return tl::unexpected(picture.error());
      (*picture)["seconds"] = screenshots_[next_picture_];
      pictures_.push_back(std::move(*picture));
    }
    if (!film_) return {};
    if (const auto drawn = picture_taker_.draw(game_, debris()); !drawn) return tl::unexpected(drawn.error());
    return film_->add(picture_taker_.picture());
  }

  /// Waits for the answers that are due, so that a run is the same on every machine. Returns milliseconds
  /// without the waiting.
  Expected<double> step_at_fixed_pace() {
    double spent = 0;
    for (int k = 0; k < kStepsPerFrame; ++k) {
      if (game_.replayed() && (options_.continue_from.empty() || !go_on())) break;
      explode_together();
      if (auto ready = wait_until([this] { return lockstep_ ? lockstep_->ready() : game_.ready(); }); !ready)
        return tl::unexpected(ready.error());
      const Clock::time_point begin = Clock::now();
      const double busy = processor_milliseconds();
      if (lockstep_)
        lockstep_->step();
      else
        game_.step();
      spent += milliseconds_since(begin);
      work_ += processor_milliseconds() - busy;
      sense();
    }
    return spent;
  }
  /// Waits for `done`. With a connected player or server, every wait ends with an answer or an error.
  Expected<void> wait_until(const std::function<bool()>& done) {
    while (!done()) {
      if (lockstep_ && lockstep_->trouble()) return fail(ErrorCode::kUnavailable, *lockstep_->trouble());
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      tell_of_absence();
      if (absent_since_ && Clock::now() - *absent_since_ > options_.longest_absence)
        return fail(ErrorCode::kUnavailable, "No server has answered at " + server() + " for " +
                                                 std::to_string(options_.longest_absence.count() / 1000) +
                                                 " s.");
    }
    return {};
  }
  /// In a game for two, sends this player's explosions.
  void explode_together() {
    const double now = static_cast<double>(game_.world().steps()) * settings_.world.step;
    for (; lockstep_ && next_blast_ < options_.blasts.size() &&
           options_.blasts[next_blast_].time <= now + kSameTime;
         ++next_blast_)
      lockstep_->explode(options_.blasts[next_blast_].blast);
  }
  /// Call when the recording has ended. Returns whether to continue in this frame, and restarts the clock.
  bool go_on() {
    game_.hand_over();
    const std::chrono::duration<double> played(
        frame_length_ * std::ceil(static_cast<double>(game_.world().steps()) / kStepsPerFrame));
    start_ = Clock::now() - std::chrono::duration_cast<Clock::duration>(played);
    return options_.fixed_step;
  }
  double step_in_real_time(double now) {
    game_.throw_scripted(now);
    const Clock::time_point begin = Clock::now();
    const double busy = processor_milliseconds();
    game_.advance(frame_length_, true);
    const double spent = milliseconds_since(begin);
    work_ += processor_milliseconds() - busy;
    sense();
    const std::chrono::duration<double> end(now + frame_length_);
    std::this_thread::sleep_until(start_ + std::chrono::duration_cast<Clock::duration>(end));
    return spent;
  }
  /// Reports this once, because a game that waits for an absent server looks as if it hangs.
  void tell_of_absence() {
    if (!options_.requests || client_.status().state != protocol::ServerState::kAbsent) {
      absent_since_.reset();
      return;
    }
    if (!absent_since_) absent_since_ = Clock::now();
    if (std::exchange(absence_told_, true)) return;
    std::fprintf(stderr, "fracture-client: no server answers at %s\n", server().c_str());
  }
  std::string server() const {
    return printable(options_.server.host) + ":" + std::to_string(options_.server.port);
  }
  /// Passes what was seen and heard to the effects and the sound.
  void sense() {
    if (!watched()) return;
    const world::Witnessed witnessed = game_.take_witnessed();
    debris_.follow(game_.world(), witnessed, materials_of(game_));
    if (sound_) sound_->add(game_, witnessed);
  }
  bool watched() const { return settings_.world.max_witnessed > 0; }
  const effects::Debris* debris() const { return options_.effects ? &debris_ : nullptr; }

  Expected<double> draw() {
    const auto drawn = picture_taker_.draw(game_, debris());
    if (!drawn) return tl::unexpected(drawn.error());
    submit_times_.push_back(drawn->submit_ms);
    most_draw_calls_ = std::max(most_draw_calls_, drawn->draw_calls);
    return drawn->submit_ms;
  }

  json result() {
    double fastest_ball = 0;
    for (const scenes::Throw& thrown : game_.scene().throws)
      fastest_ball = std::max(fastest_ball, glm::length(thrown.velocity));
    json result = summary(game_, client_, options_);
    result["pictures"] = std::move(pictures_);
    std::move(times_).write_to(result);
    result["frames"]["processor"] = summary_of_frames(std::move(work_times_));
    if (options_.draw) {
      result["submit"] = summary_of_frames(std::move(submit_times_));
      result["submit"]["most_draw_calls"] = most_draw_calls_;
    }
    result["fastest_fragment"] = fastest_;
    result["fastest_ball"] = fastest_ball;
    return result;
  }

  static constexpr double kSameTime = 1e-9;  // seconds

  const Options& options_;
  protocol::Client client_;
  const game::GameSettings settings_;
  Players players_;
  game::Game game_;
  std::optional<game::Lockstep> lockstep_;  ///< in a game for two
  PictureTaker picture_taker_;
  std::optional<SoundTrack> sound_;
  std::optional<film::Film> film_;
  effects::Debris debris_;
  std::vector<double> screenshots_;  // seconds, in order
  const double frame_length_;        // seconds
  Clock::time_point start_{};
  std::size_t next_picture_ = 0, next_blast_ = 0, most_draw_calls_ = 0;
  json pictures_ = json::array();
  FrameTimes times_;
  std::vector<double> work_times_;  // processor time of each frame's simulation, in milliseconds
  double work_ = 0;
  std::vector<double> submit_times_;
  double fastest_ = 0;
  bool absence_told_ = false;
  std::optional<Clock::time_point> absent_since_;
};

/// Warns about requested pictures and explosions that come after the end and so never happen.
void warn_of_what_is_late(const Options& options) {
  const auto warn = [&](const char* what, double time) {
    std::fprintf(stderr, "fracture-client: the %s at %g s is skipped, because the run ends at %g s\n", what,
                 time, options.seconds);
  };
  for (const double time : options.screenshots)
    if (time > options.seconds) warn("picture", time);
  for (const scenes::TimedBlast& blast : options.blasts)
    if (blast.time >= options.seconds) warn("explosion", blast.time);
}

}  // namespace

Expected<scenes::Scene> scene_of(const Options& options) {
  Expected<scenes::Scene> scene = options.files.empty() ? scenes::make_scene(options.scene)
                                                        : scenes::scene_of_files(options.files, options.unit);
  if (scene && !options.material.empty()) set_material(*scene, options.material);
  return scene;
}

Expected<json> run_headless(const Options& asked) {
  Options options = asked;
  std::shared_ptr<const game::Recording> replay;
  if (const std::string& path = options.replay.empty() ? options.continue_from : options.replay;
      !path.empty()) {
    Expected<std::shared_ptr<const game::Recording>> recording = recording_for(options, path);
    if (!recording) return tl::unexpected(recording.error());
    replay = std::move(*recording);
  }
  Expected<Players> players = meet(options);
  if (!players) return tl::unexpected(players.error());
  if (!replay) warn_of_what_is_late(options);
  if (options.fixed_step) {  // otherwise, timeouts would depend on the server's speed
    options.server.realtime = false;
    options.server.answer_timeout = std::chrono::seconds(60);
    options.server.patience = std::chrono::seconds(80);  // less than the other player's patience (Lockstep)
  }
  Expected<scenes::Scene> scene = scene_of(options);
  if (!scene) return tl::unexpected(scene.error());
  if (const auto agreed = agree(*players, options, *scene); !agreed) return tl::unexpected(agreed.error());
  if (replay)
    if (const auto same = check_scene(replay->header, *scene); !same) return tl::unexpected(same.error());
  if (!options.throws || !options.replay.empty()) scene->throws.clear();
  if (options.replay.empty() && !players->link) scene->blasts = options.blasts;
  std::error_code ignored;
  std::filesystem::create_directories(options.out, ignored);
  game::GameSettings settings = settings_of(options);
  auto recorder = recorder_for(options.log, header_of(options, *scene));
  if (!recorder) return tl::unexpected(recorder.error());
  settings.recorder = std::move(*recorder);
  settings.replay = std::move(replay);
  return HeadlessRun(options, std::move(*scene), std::move(settings), std::move(*players)).run();
}

}  // namespace fracture::app
