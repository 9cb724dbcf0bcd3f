// How far a bake is: a bar that redraws itself on a terminal, plain lines elsewhere.
#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <set>
#include <string>

namespace fracture::bake {

/// For one file: the stages of its computation. Called from any thread.
class StageProgress {
 public:
  explicit StageProgress(bool quiet);
  void show(const char* stage, double fraction);
  /// Removes the bar, so that what is printed next begins on an empty line.
  void finish();

 private:
  const bool quiet_, terminal_;
  std::mutex mutex_;
  std::string stage_;
  std::set<std::string> seen_;
  int percent_ = -1;
  bool drawn_ = false;
};

/// For many files: how many are done, and when the rest will be by the pace so far (kept outputs, which take
/// no time, are no part of it). Elsewhere than on a terminal a line at the first and the last job and at most
/// every ten seconds.
class JobProgress {
 public:
  JobProgress(std::size_t jobs, bool quiet);
  /// Above the bar, a line that stays.
  void say(const std::string& line);
  void done(bool kept, bool refused);
  void finish();

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
