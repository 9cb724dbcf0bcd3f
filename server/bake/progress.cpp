#include "server/bake/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/base/printable.hpp"

namespace fracture::bake {
namespace {

constexpr int kWidth = 40;

std::string bar(double fraction) {
  const int full = static_cast<int>(fraction * kWidth);
  return "[" + std::string(static_cast<std::size_t>(full), '#') +
         std::string(static_cast<std::size_t>(kWidth - full), '.') + "]";
}

std::string time_text(double seconds) {
  const auto s = static_cast<long>(std::ceil(seconds));
  char text[32];
  if (s < 3600)
    std::snprintf(text, sizeof text, "%ld:%02ld", s / 60, s % 60);
  else
    std::snprintf(text, sizeof text, "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
  return text;
}

}  // namespace

StageProgress::StageProgress(bool quiet) : quiet_(quiet), terminal_(::isatty(STDERR_FILENO) == 1) {}

void StageProgress::stage(Stage stage, double fraction) {
  if (quiet_) return;
  const std::lock_guard lock(mutex_);
  const double part = std::clamp(fraction, 0.0, 1.0);
  const int percent = static_cast<int>(100 * part);
  const bool new_stage = stage_ != stage;
  if (!new_stage && percent == percent_) return;
  stage_ = stage;
  percent_ = percent;
  if (terminal_) {
    std::fprintf(stderr, "\r%-16s %s %3d%%", name_of(stage), bar(part).c_str(), percent);
    std::fflush(stderr);
    drawn_ = true;
  } else if (seen_.insert(stage).second) {
    std::fprintf(stderr, "%s\n", name_of(stage));
  }
}

void StageProgress::clear() {
  if (drawn_) std::fprintf(stderr, "\r\033[K");
  drawn_ = false;
}

void StageProgress::say(const std::string& line) {
  const std::lock_guard lock(mutex_);
  clear();
  std::fprintf(stderr, "%s\n", printable_lines(line).c_str());
}

void StageProgress::finish() {
  const std::lock_guard lock(mutex_);
  clear();
}

JobProgress::JobProgress(std::size_t jobs, bool quiet)
    : jobs_(jobs), quiet_(quiet), terminal_(::isatty(STDERR_FILENO) == 1) {}

void JobProgress::say(const std::string& line) {
  const std::lock_guard lock(mutex_);
  if (drawn_) std::fprintf(stderr, "\r\033[K");
  drawn_ = false;
  std::fprintf(stderr, "%s\n", printable_lines(line).c_str());
}

void JobProgress::done(bool kept, bool refused) {
  const std::lock_guard lock(mutex_);
  ++done_;
  kept_ += kept;
  refused_ += refused;
  const Clock::time_point now = Clock::now();
  const std::chrono::milliseconds pace(terminal_ ? 100 : 10'000);
  if (quiet_ || (done_ > 1 && done_ < jobs_ && now - drawn_at_ < pace)) return;
  drawn_at_ = now;
  draw();
}

void JobProgress::draw() {
  const double took = std::chrono::duration<double>(Clock::now() - begun_).count();
  const std::size_t made = done_ - kept_;
  std::string line = std::to_string(done_) + " of " + std::to_string(jobs_);
  if (kept_ > 0) line += ", " + std::to_string(kept_) + " kept";
  if (refused_ > 0) line += ", " + std::to_string(refused_) + " refused";
  line += ", " + time_text(took);
  if (made > 0 && done_ < jobs_)
    line +=
        ", " + time_text(took / static_cast<double>(made) * static_cast<double>(jobs_ - done_)) + " to go";
  if (terminal_) {
    std::fprintf(stderr, "\r\033[K%s %s",
                 bar(static_cast<double>(done_) / static_cast<double>(jobs_)).c_str(), line.c_str());
    std::fflush(stderr);
    drawn_ = true;
  } else {
    std::fprintf(stderr, "%s\n", line.c_str());
  }
}

void JobProgress::finish() {
  const std::lock_guard lock(mutex_);
  if (drawn_) std::fprintf(stderr, "\n");
  drawn_ = false;
}

}  // namespace fracture::bake
