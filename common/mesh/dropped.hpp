// Things in the source that the answer does not contain. Warnings and notes are sentences; this list is for programs, too.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace fracture {

/// Something in the source that the answer does not contain.
struct Dropped {
  std::string what;    ///< kind, in the words of the source's format: "light", "animation", "extension"
  std::string name;    ///< UTF-8; name in the source, or the place there; may be empty
  std::string reason;  ///< one clause: "fragments have no lights"
  friend bool operator==(const Dropped&, const Dropped&) = default;
};

/// Maximum number of entries of one kind. Further ones are counted in one more entry.
inline constexpr std::size_t kMostDropped = 20;
/// Maximum length of a name in bytes.
inline constexpr std::size_t kLongestDroppedName = 63;

/// Makes the list ready for a report, so that its length depends only on the number of kinds. Removes repeated entries and
/// cuts long names at a character. Keeps the first kMostDropped entries of each kind; one entry after them counts the rest.
/// Kinds are in the order of their first entries. A list that is ready does not change.
void shorten_dropped(std::vector<Dropped>& list);

/// Returns the entry as readable text: "light Lamp: fragments have no lights".
std::string to_text(const Dropped& dropped);

}  // namespace fracture
