#include "common/mesh/dropped.hpp"

#include <map>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "common/base/words.hpp"

namespace fracture {
namespace {

constexpr std::string_view kNotListed = " not listed";  // end of the reason of an entry for all further ones

void shorten(std::string& name) {
  if (name.size() <= kLongestDroppedName) return;
  std::size_t end = kLongestDroppedName;
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;
  name.resize(end);
}

}  // namespace

void shorten_dropped(std::vector<Dropped>& list) {
  struct Kind {
    std::vector<Dropped> listed;
    std::size_t further = 0;
  };
  std::vector<Kind> kinds;
  std::map<std::string, std::size_t> number;
  std::set<std::tuple<std::string, std::string, std::string>> known;
  for (Dropped& entry : list) {
    shorten(entry.name);
    if (!known.emplace(entry.what, entry.name, entry.reason).second) continue;
    const auto [at, added] = number.emplace(entry.what, kinds.size());
    if (added) kinds.emplace_back();
    Kind& kind = kinds[at->second];
    if (kind.listed.size() < kMostDropped || entry.reason.ends_with(kNotListed))
      kind.listed.push_back(std::move(entry));
    else
      ++kind.further;
  }
  list.clear();
  for (Kind& kind : kinds) {
    const std::string what = kind.listed.front().what;
    for (Dropped& entry : kind.listed) list.push_back(std::move(entry));
    if (kind.further > 0)
      list.push_back({what, {}, counted(kind.further, "more is", "more are") + std::string(kNotListed)});
  }
}

std::string to_text(const Dropped& dropped) {
  return dropped.what + (dropped.name.empty() ? "" : " " + dropped.name) + ": " + dropped.reason;
}

}  // namespace fracture
