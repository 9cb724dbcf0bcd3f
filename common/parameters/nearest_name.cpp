#include "common/parameters/nearest_name.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace fracture {
namespace {

/// How many letters are to be inserted, left out, changed or swapped with their neighbour (Damerau 1964; by
/// the recurrence of Wagner and Fischer 1974, no letter edited twice).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before.swap(last);
    last.swap(row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j - 1] + (a[i - 1] != b[j - 1]), last[j] + 1, row[j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row.back();
}

}  // namespace

std::optional<std::string> nearest_name(std::string_view name, std::span<const std::string> known) {
  std::optional<std::string> nearest;
  std::size_t least = 1 + name.size() / 3;
  for (const std::string& candidate : known) {
    if (name.size() > 2 * candidate.size()) continue;
    if (const std::size_t distance = edit_distance(name, candidate); distance < least) {
      least = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

std::vector<std::string> nearest_names(std::string_view name, std::span<const std::string> known,
                                       std::size_t most) {
  constexpr std::size_t kLongest = 40;  // beyond this a name is none that was misspelt
  name = name.substr(0, kLongest);
  std::vector<std::pair<std::size_t, std::size_t>> order;  // distance, index
  for (std::size_t k = 0; k < known.size(); ++k) order.emplace_back(edit_distance(name, known[k]), k);
  most = std::min(most, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(most), order.end());
  std::vector<std::string> names;
  for (std::size_t k = 0; k < most; ++k) names.push_back(known[order[k].second]);
  return names;
}

}  // namespace fracture
