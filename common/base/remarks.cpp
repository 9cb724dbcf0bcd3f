#include "common/base/remarks.hpp"

#include <algorithm>
#include <utility>

namespace fracture {
namespace {

/// A file can cause as many different sentences as it has names. Each one is compared with all before it.
constexpr std::size_t kMostSentences = 1000;

void add_once(std::string sentence, std::vector<std::string>& list) {
  if (list.size() > kMostSentences) return;  // the last sentence says so
  if (std::find(list.begin(), list.end(), sentence) != list.end()) return;
  if (list.size() == kMostSentences)
    sentence = "The limit is 1,000 sentences, so further ones are not listed.";
  list.push_back(std::move(sentence));
}

}  // namespace

void Remarks::warn(std::string sentence) { add_once(std::move(sentence), warnings); }

void Remarks::note(std::string sentence) { add_once(std::move(sentence), notes); }

void Remarks::add(const Remarks& others) {
  for (const std::string& warning : others.warnings) warn(warning);
  for (const std::string& text : others.notes) note(text);
}

}  // namespace fracture
