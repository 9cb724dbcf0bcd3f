// A further hit on a fractured object: puts the fragments that it changed into the complete set.
//
// Fragments and bonds keep their numbers, so that bodies, marks and requests that refer to the others stay
// valid. A changed fragment keeps its number. New fragments are appended, as are all bonds of new and changed
// fragments. Removed ones keep only their number (Fragment::gone, Bond::gone).
#pragma once

#include <cstdint>
#include <vector>

#include "client/world/fragments.hpp"

namespace fracture::world {

struct ChangedFragments {
  FragmentSet set;
  std::vector<std::uint32_t> replaced;  ///< fragments of the earlier set that are gone or changed; ascending
  std::vector<std::uint32_t> made;      ///< new or changed fragments of the set; ascending
  std::size_t first_bond = 0;           ///< the first new bond
};

/// kMalformedMesh if the change does not fit the set: it names fragments that do not exist, or adds some that
/// do. kTooLarge.
Expected<ChangedFragments> apply_change(const FragmentSet& before, FragmentChange change);

/// Whether a new bond does not hold because an existing crack runs there: the nearest bond that it may have
/// come from was `broken` (one flag for each earlier bond). Candidates are the removed bonds between the same
/// two fragments. If one end of the new bond is an unchanged fragment, they are the removed bonds between
/// that fragment and any other.
bool is_cracked(const ChangedFragments& changed, const FragmentSet& before, std::size_t bond,
                const std::vector<bool>& broken);

}  // namespace fracture::world
