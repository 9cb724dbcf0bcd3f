// Patterns of a shell for names, as fnmatch() of POSIX without flags takes them, but counted: no pattern and no name makes
// the caller wait for what it cannot stop, and a name may hold any byte.
#pragma once

#include <cstddef>
#include <stop_token>
#include <string_view>
#include <utility>

namespace fracture::bake {

/// What comparing may cost: comparisons of one byte each.
class MatchBudget {
 public:
  MatchBudget(std::size_t steps, std::stop_token stop) : left_(steps), stop_(std::move(stop)) {}
  /// Whether to go on.
  bool step() {
    if (left_ == 0 || stopped_) return false;
    if (--left_ % kStepsBetweenLooks == 0) stopped_ = stop_.stop_requested();
    return !stopped_;
  }
  bool spent() const { return left_ == 0; }
  bool stopped() const { return stopped_; }

 private:
  static constexpr std::size_t kStepsBetweenLooks = 1u << 16;  // well below a millisecond
  std::size_t left_;
  bool stopped_ = false;
  std::stop_token stop_;
};

/// `*` is any text, '/' included, `?` one byte, `[a-z]`, `[!a-z]` and `[[:digit:]]` one of these, a backslash takes the next as
/// it is. False too where the budget ends.
bool matches_pattern(std::string_view pattern, std::string_view text, MatchBudget& budget);

/// Matches its own text and nothing else.
inline bool is_plain(std::string_view pattern) {
  return pattern.find_first_of("*?[\\") == std::string_view::npos;
}

}  // namespace fracture::bake
