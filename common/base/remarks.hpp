// Sentences for people about a result, in two lists.
#pragma once

#include <string>
#include <vector>

namespace fracture {

/// Whole sentences. Each sentence is in only one of the lists.
struct Remarks {
  std::vector<std::string> warnings;  ///< user must act: what happened, what it means, and what to do
  std::vector<std::string> notes;     ///< information about what was done; no action is needed

  /// Adds the sentence unless the list already contains it.
  void warn(std::string sentence);
  void note(std::string sentence);
  /// Adds the sentences of `others` that are not in the lists yet.
  void add(const Remarks& others);

  bool empty() const { return warnings.empty() && notes.empty(); }
  bool operator==(const Remarks&) const = default;
};

}  // namespace fracture
