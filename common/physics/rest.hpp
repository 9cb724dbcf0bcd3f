// Makes bodies rest at spawn: no two bodies that may collide overlap by more than a tolerance, because a solver would throw
// them apart. Hulls of one diagram are disjoint; the others are measured (overlapping_bodies.hpp). Pairs that overlap get a
// collision filter (collision_filters.hpp). If the filters need more systems than engines have, the pairs that do not fit
// are trimmed by a plane across their least depth, so that as much as possible is left of both hulls.
//
// Filters, and trimming when filters run out, depend on all bodies. So a hit may change them far away from it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/physics/collision_filters.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/physics/overlapping_bodies.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Maximum allowed overlap, as a share of the longest side of the solid's box: 0.2 mm at 1 m.
inline constexpr double kRestTolerance = 2e-4;
/// Maximum allowed overlap, m.
inline double rest_tolerance(const Solid& solid) { return kRestTolerance * solid.box.longest_side(); }

/// How bodies whose hulls overlap are kept from colliding.
enum class HullFilters {
  kNone,     ///< the file has no filters
  kSystems,  ///< KHR_physics_rigid_bodies
};

/// The certificate's numbers about rest.
struct RestFigures {
  /// Pairs of bodies whose hulls overlap by more than the tolerance, after trimming at contacts.
  std::uint32_t pairs = 0;
  std::uint32_t filtered = 0;  ///< pairs among these that a collision filter excludes
  std::uint32_t left = 0;      ///< pairs among these that may collide nevertheless; normally 0 with filters
  std::uint32_t trimmed = 0;   ///< bodies with a trimmed hull
  std::uint32_t systems = 0;   ///< collision systems, at most 32
  double deepest = 0;          ///< m: the deepest overlap of two bodies that may collide; 0: none overlap
  double tolerance = 0;        ///< m
  double least_share = 1;      ///< the least share of its volume that a trimmed hull kept
  bool operator==(const RestFigures&) const = default;
};

/// A companion of a FragmentSet with hulls.
struct Rest {
  RestFigures figures;
  CollisionFilters filters;  ///< by fragment
  /// Ids of pairs that must not collide, in the answer's order. In a delta: only pairs with a new or changed fragment.
  std::vector<std::array<std::uint64_t, 2>> filtered;
  bool trimmed_for_filters = false;  ///< hulls were trimmed because filters ran out
};

/// `tolerance`: m. Does not change the hulls; sets trimmed_for_filters if they need trimming. Throws Interrupted.
Rest find_rest(const Bodies& bodies, const CellsOfBodies& cells, double tolerance, HullFilters filters,
               const Execution& execution);

/// The same for a whole set, but trims the hulls if filters run out.
Rest bring_to_rest(const FragmentSet& set, CollisionHulls& hulls, const CellsOfBodies& cells,
                   double tolerance, HullFilters filters, const Execution& execution);

}  // namespace fracture
