// Shell patterns for names, as fnmatch() in POSIX matches them without flags. Two differences: steps are
// counted and the matching can be stopped, so that no pattern takes too long; and a name may contain any
// byte.
#pragma once

#include <cstddef>
#include <stop_token>
#include <string_view>
#include <utility>

namespace fracture {

/// Limits the cost of matching, counted in comparisons of one byte.
class MatchBudget {
 public:
  MatchBudget(std::size_t steps, std::stop_token stop) : left_(steps), stop_(std::move(stop)) {}
  /// Counts one step. Returns whether to continue.
  bool step() {
    if (left_ == 0 || stopped_) return false;
    if (--left_ % kStepsBetweenLooks == 0) stopped_ = stop_.stop_requested();
    return !stopped_;
  }
  bool spent() const { return left_ == 0; }
  bool stopped() const { return stopped_; }

 private:
  static constexpr std::size_t kStepsBetweenLooks = 1u << 16;  // these take well below a millisecond
  std::size_t left_;
  bool stopped_ = false;
  std::stop_token stop_;
};

/// Matches the whole text. `*` is any text including '/', `?` is one byte, `[a-z]`, `[!a-z]` and
/// `[[:digit:]]` are one byte of a set, and a backslash makes the next byte literal. Also returns false if
/// the budget runs out.
bool matches_pattern(std::string_view pattern, std::string_view text, MatchBudget& budget);

/// Returns whether the pattern has no special characters and so matches only its own text.
inline bool is_plain(std::string_view pattern) {
  return pattern.find_first_of("*?[\\") == std::string_view::npos;
}

}  // namespace fracture
