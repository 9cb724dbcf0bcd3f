// Sentences for people about a result, in two lists.
#pragma once

#include <string>
#include <vector>

namespace fracture {

/// Whole sentences. Each one is in one of the lists.
struct Remarks {
  std::vector<std::string>
      warnings;                    ///< to act on: what happened, what it means for the result, and what to do
  std::vector<std::string> notes;  ///< what was done; nothing has to be done about it

  /// Adds the sentence unless the list has it.
  void warn(std::string sentence);
  void note(std::string sentence);
  /// Adds both lists of `others` that are not there yet.
  void add(const Remarks& others);

  bool empty() const { return warnings.empty() && notes.empty(); }
  bool operator==(const Remarks&) const = default;
};

}  // namespace fracture
