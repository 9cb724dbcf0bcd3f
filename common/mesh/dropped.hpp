// Things in the source that the answer does not contain. Warnings and notes are sentences; this list is for programs, too.
#pragma once

#include <string>

namespace fracture {

/// Something in the source that the answer does not contain.
struct Dropped {
  std::string what;  ///< kind, in the words of the source's format: "light", "animation", "extension"
  std::string
      name;  ///< UTF-8; what the source calls it, or where it is; empty if the source has no name for it
  std::string reason;  ///< one clause: "fragments have no lights"
  friend bool operator==(const Dropped&, const Dropped&) = default;
};

}  // namespace fracture
