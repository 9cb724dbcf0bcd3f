// Shows the progress of a bake: a progress bar on a terminal, plain lines elsewhere.
#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include "common/base/stage.hpp"

namespace fracture::bake {

/// Writes to standard error. Thread-safe.
class Progress {
 public:
  virtual ~Progress() = default;
  /// Prints a line that stays visible above the bar.
  virtual void say(const std::string& line) = 0;
  /// Reports the stage of a job's computation and the fraction of it that is done.
  virtual void stage(Stage, double) {}
  virtual void done(bool /*kept*/, bool /*refused*/) {}
  /// Leaves the cursor on an empty line.
  virtual void finish() = 0;
};

/// Progress for one file: the stages of its computation.
class StageProgress : public Progress {
 public:
  explicit StageProgress(bool quiet);
  void say(const std::string& line) override;
  void stage(Stage stage, double fraction) override;
  void finish() override;

 private:
  void clear();

  const bool quiet_, terminal_;
  std::mutex mutex_;
  std::optional<Stage> stage_;
  std::set<Stage> seen_;
  int percent_ = -1;
  bool drawn_ = false;
};

/// Progress for many files: how many are done, and the estimated end at the current pace (kept outputs, which
/// take no time, are ignored). Without a terminal, prints a line for the first and the last job and at most
/// one every ten seconds.
class JobProgress : public Progress {
 public:
  JobProgress(std::size_t jobs, bool quiet);
  void say(const std::string& line) override;
  void done(bool kept, bool refused) override;
  void finish() override;

 private:
  using Clock = std::chrono::steady_clock;
  void draw();

  const std::size_t jobs_;
  const bool quiet_, terminal_;
  const Clock::time_point begun_ = Clock::now();
  std::mutex mutex_;
  std::size_t done_ = 0, kept_ = 0, refused_ = 0;
  Clock::time_point drawn_at_{};
  bool drawn_ = false;
};

}  // namespace fracture::bake
