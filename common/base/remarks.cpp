#include "common/base/remarks.hpp"

#include <algorithm>
#include <utility>

namespace fracture {
namespace {

void add_once(std::string sentence, std::vector<std::string>& list) {
  if (std::find(list.begin(), list.end(), sentence) == list.end()) list.push_back(std::move(sentence));
}

}  // namespace

void Remarks::warn(std::string sentence) { add_once(std::move(sentence), warnings); }

void Remarks::note(std::string sentence) { add_once(std::move(sentence), notes); }

void Remarks::add(const Remarks& others) {
  for (const std::string& warning : others.warnings) warn(warning);
  for (const std::string& text : others.notes) note(text);
}

}  // namespace fracture
