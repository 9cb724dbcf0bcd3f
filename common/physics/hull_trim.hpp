// Hulls cut back where parts overlap. If a part sticks into another one, the hulls of the first end at the surface of the
// second: a hull that reaches beyond it is cut by a plane across the contact. A hull that would lose more than a tenth of
// its volume is not cut; then a collision filter keeps the bodies apart.
//
//      ┌───────────┐  part a            the contact's area is the surface of b inside a: the plane touches it
//      │  ┌─────┐  │                    on the side of a, and its normal is that of the contact
//   ═══╪══╪═════╪══╪═══ plane
//      └──┼─────┼──┘
//         │     │     part b
//
// A plane depends on the contact, and the cut on the plane and the hull. So a hit does not change the hulls of other bodies.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// The least share of its volume that a hull must keep when it is trimmed at contacts.
inline constexpr double kLeastShareAtContacts = 0.9;

/// A half-space that hulls end at, in the frame of the solid: normal · x <= offset.
struct TrimPlane {
  Vec3d normal;       ///< unit length
  double offset = 0;  ///< m
  Box other;          ///< box of the other part; hulls whose boxes miss it are not cut
};

/// The planes at which the hulls of each part end. Linear in the contacts' pieces. Throws Interrupted.
class ContactPlanes {
 public:
  ContactPlanes(const Solid& solid, const Execution& execution);
  bool empty() const { return planes_.empty(); }
  std::span<const TrimPlane> of(std::uint32_t part) const {
    return empty() ? std::span<const TrimPlane>()
                   : std::span(planes_).subspan(first_[part], first_[part + 1] - first_[part]);
  }

 private:
  std::vector<TrimPlane> planes_;     // by part
  std::vector<std::uint32_t> first_;  // per part, and the end
};

/// Returns the part of a hull within the half-space; no points if that is flat or empty. `normal` and `offset` are as in
/// TrimPlane, but in the hull's frame. Throws Interrupted.
CollisionHull trimmed(const CollisionHull& hull, const Vec3d& normal, double offset,
                      const Execution& execution);

/// Replaces a hull by a part of it, and records the volume that it had before it was trimmed for the first time. `volume`: of
/// the hull, m³.
void keep_trimmed(CollisionHull& hull, CollisionHull part, double volume);

/// The least share of its volume that one of the hulls kept when it was trimmed, in [0, 1]; 1 if none was trimmed. Computed from
/// the hulls' points, so it describes what is written.
double least_share(std::span<const CollisionHull> hulls);

/// Trims the hulls of fragments that were not trimmed before (FragmentHulls::seen_contacts). Throws Interrupted.
void trim_at_contacts(const FragmentSet& set, const Solid& solid, CollisionHulls& hulls,
                      const Execution& execution);

}  // namespace fracture
