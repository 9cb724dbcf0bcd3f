// Which bodies must not collide, in the form that engines use (KHR_physics_rigid_bodies; bit masks in Havok, Rapier
// and Bullet). Each body is in one of a few systems, and lists the systems that it does not collide with.
//
// Two bodies do not collide if one of them lists the other's system. So it is enough if one body of every pair is in a
// named system, which the other body lists. Bodies may share a named system only if they have the same partners (twins).
// All bodies without a named system share system 0, which no body lists. The named systems are a vertex cover of the graph
// of pairs, found greedily (Johnson 1974, "Approximation algorithms for combinatorial problems").
//
//     pairs  a-x a-y b-x b-y c-z      systems  0: x y z    1: a b    2: c
//     x and y list 1, z lists 2; x and z collide, and so do a and c
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"

namespace fracture {

/// Havok has 32 bits for systems.
inline constexpr std::uint32_t kMostCollisionSystems = 32;

/// Indices of two bodies, a < b.
struct BodyPair {
  std::uint32_t a = 0, b = 0;
  friend auto operator<=>(const BodyPair&, const BodyPair&) = default;
};

struct CollisionFilters {
  struct Filter {
    std::uint32_t system = 0;
    std::vector<std::uint32_t> excluded;  ///< systems, ascending
    bool operator==(const Filter&) const = default;
  };
  std::uint32_t systems = 0;           ///< number of systems, including system 0; 0: none are needed
  std::vector<Filter> filters;         ///< all different, in the order of the first body of each
  std::vector<std::uint32_t> of_body;  ///< index into filters; kNoIndex: no filter. Empty: no body has one
  std::vector<BodyPair> beyond;        ///< pairs that would need more systems, ascending; not excluded
};

/// Excludes exactly the `pairs` (ascending, without duplicates), except those in `beyond`. The result depends only on the
/// pairs and the order of the bodies. Near-linear in the pairs, times the number of systems. Throws Interrupted.
CollisionFilters make_collision_filters(std::size_t bodies, std::span<const BodyPair> pairs,
                                        const Execution& execution);

}  // namespace fracture
