#include "common/base/nearest_name.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace fracture {
namespace {

/// Returns the number of letters to insert, delete, change or swap with their neighbour (Damerau 1964). It
/// is computed with the recurrence of Wagner and Fischer (1974), which edits no letter twice.
class EditDistance {
 public:
  explicit EditDistance(std::string_view a) : a_(a) {
    for (const char c : a_) ++letters_[static_cast<unsigned char>(c)];
  }

  /// Returns a lower bound for the distance: the number of letters that occur in only one of the names
  /// (Bartolini, Ciaccia and Patella, "String matching with metric trees using an approximate distance",
  /// 2002). For most names this bound is enough.
  std::size_t at_least(std::string_view b) const {
    std::array<std::uint16_t, 256> left = letters_;
    std::size_t common = 0;
    for (const char c : b) {
      std::uint16_t& count = left[static_cast<unsigned char>(c)];
      if (count > 0) --count, ++common;
    }
    return std::max(a_.size(), b.size()) - common;
  }

  std::size_t to(std::string_view b) {
    before_.assign(b.size() + 1, 0);
    last_.assign(b.size() + 1, 0);
    row_.resize(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row_[j] = j;
    for (std::size_t i = 1; i <= a_.size(); ++i) {
      before_.swap(last_);
      last_.swap(row_);
      row_[0] = i;
      for (std::size_t j = 1; j <= b.size(); ++j) {
        row_[j] = std::min({last_[j - 1] + (a_[i - 1] != b[j - 1]), last_[j] + 1, row_[j - 1] + 1});
        if (i > 1 && j > 1 && a_[i - 1] == b[j - 2] && a_[i - 2] == b[j - 1])
          row_[j] = std::min(row_[j], before_[j - 2] + 1);
      }
    }
    return row_.back();
  }

 private:
  const std::string_view a_;
  std::array<std::uint16_t, 256> letters_{};
  std::vector<std::size_t> before_, last_, row_;
};

/// Maximum number of letters. A longer name is not a misspelling.
constexpr std::size_t kLongest = 40;

}  // namespace

std::optional<std::string> nearest_name(std::string_view name, std::span<const std::string> known) {
  std::optional<std::string> nearest;
  if (name.size() > 2 * kLongest) return nearest;
  EditDistance distance(name);
  std::size_t least = 1 + name.size() / 3;
  for (const std::string& candidate : known) {
    if (distance.at_least(candidate) >= least) continue;
    if (const std::size_t edits = distance.to(candidate); edits < least) {
      least = edits;
      nearest = candidate;
    }
  }
  return nearest;
}

std::vector<std::string> nearest_names(std::string_view name, std::span<const std::string> known,
                                       std::size_t most) {
  name = name.substr(0, kLongest);
  EditDistance distance(name);
  std::vector<std::pair<std::size_t, std::size_t>> order;  // distance, index
  for (std::size_t k = 0; k < known.size(); ++k) order.emplace_back(distance.to(known[k]), k);
  most = std::min(most, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(most), order.end());
  std::vector<std::string> names;
  for (std::size_t k = 0; k < most; ++k) names.push_back(known[order[k].second]);
  return names;
}

std::string did_you_mean(std::string_view name, std::span<const std::string> known) {
  constexpr std::size_t kMostSuggested = 3;
  std::string text;
  if (name.size() > 2 * kLongest) return text;
  std::vector<std::string> near;
  EditDistance distance(name);
  std::size_t least = name.size() / 3;
  for (const std::string& candidate : known) {
    if (distance.at_least(candidate) > least) continue;
    const std::size_t edits = distance.to(candidate);
    if (edits > least) continue;
    if (edits < least) near.clear();
    least = edits;
    if (near.size() < kMostSuggested && std::find(near.begin(), near.end(), candidate) == near.end())
      near.push_back(candidate);
  }
  for (std::size_t k = 0; k < near.size(); ++k)
    text += (k == 0 ? " Did you mean '" : k + 1 < near.size() ? "', '" : "' or '") + near[k];
  return text.empty() ? text : text + "'?";
}

}  // namespace fracture
