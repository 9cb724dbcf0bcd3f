// A further hit on what is fractured already: the fragments that it replaces, in the set of all.
//
// Fragments and bonds keep their numbers, so that bodies, marks and requests which name the others stay what they are.
// What changed takes the number of what it was; what is new, and all bonds of either, come behind the others; what is
// gone stays as a number alone (Fragment::gone, Bond::gone).
#pragma once

#include <cstdint>
#include <vector>

#include "client/world/fragments.hpp"

namespace fracture::world {

struct ChangedFragments {
  FragmentSet set;
  std::vector<std::uint32_t> replaced;  ///< fragments of the set before that are gone or changed; ascending
  std::vector<std::uint32_t> made;      ///< fragments of the set that are new or changed; ascending
  std::size_t first_bond = 0;           ///< the first bond that was not there before
};

/// kMalformedMesh where the change is of another set: it names fragments that are not there, or has some that are.
/// kTooLarge.
Expected<ChangedFragments> apply_change(const FragmentSet& before, FragmentChange change);

/// Whether a crack that was there goes where a new bond is, so that the bond does not hold: the nearest of the bonds
/// that it may have come from was `broken` (for each bond before). These are the ones that the change took away,
/// between the same two fragments; and where one end of the new bond has stayed, from that end to any other.
bool is_cracked(const ChangedFragments& changed, const FragmentSet& before, std::size_t bond,
                const std::vector<bool>& broken);

}  // namespace fracture::world
