#include "server/bake/line_faults.hpp"

#include <algorithm>
#include <map>

namespace fracture::bake {
namespace {

/// Formats ascending numbers as "2, 4 to 9, 12".
std::string ranges_of(const std::vector<std::size_t>& lines) {
  std::string text;
  for (std::size_t first = 0, last; first < lines.size(); first = last + 1) {
    last = first;
    while (last + 1 < lines.size() && lines[last + 1] == lines[last] + 1) ++last;
    text += (text.empty() ? "" : ", ") + std::to_string(lines[first]);
    if (last > first) text += (last == first + 1 ? ", " : " to ") + std::to_string(lines[last]);
  }
  return text;
}

}  // namespace

Error LineFaults::error() const {
  auto sorted = faults_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::pair<std::string, std::vector<std::size_t>>> groups;
  std::map<std::string, std::size_t> group_of;
  std::size_t left = 0;
  for (const auto& [line, detail] : sorted) {
    const auto at = group_of.find(detail);
    if (at != group_of.end()) {
      groups[at->second].second.push_back(line);
    } else if (groups.size() == kMostFaults) {
      ++left;
    } else {
      group_of.emplace(detail, groups.size());
      groups.push_back({detail, {line}});
    }
  }
  std::string text;
  for (const auto& [detail, lines] : groups) {
    text += text.empty() ? "" : "\n";
    if (lines.front() > 0)
      text += (lines.size() > 1 ? "Lines " : "Line ") + ranges_of(lines) + " of '" + manifest_ + "': ";
    text += detail;
  }
  if (left > 0) text += "\nAnd " + std::to_string(left) + " more.";
  return {ErrorCode::kBadParameter, text, {}};
}

}  // namespace fracture::bake
