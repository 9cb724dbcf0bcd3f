// Bodies that rest at spawn: no two that may collide overlap by more than a tolerance, because a solver would throw them
// apart. Hulls of one diagram are disjoint; the others are measured (overlapping_bodies.hpp). Pairs that overlap get a
// collision filter (collision_filters.hpp). If these need more systems than engines have, the pairs that do not fit are
// trimmed: each by a plane across its least depth, in the way that leaves the most of both hulls.
//
// Filters, and what is trimmed for lack of them, depend on all bodies: a hit may change them far away from it.
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

/// Overlaps that are allowed, as a share of the longest side of the solid's box: 0.2 mm at 1 m.
inline constexpr double kRestTolerance = 2e-4;
/// m
inline double rest_tolerance(const Solid& solid) { return kRestTolerance * solid.box.longest_side(); }

/// How bodies are kept apart whose hulls overlap.
enum class HullFilters {
  kNone,     ///< the file has no filters
  kSystems,  ///< KHR_physics_rigid_bodies
};

/// The certificate's figures.
struct RestFigures {
  /// Pairs of bodies whose hulls overlap by more than the tolerance, after trimming at contacts.
  std::uint32_t pairs = 0;
  std::uint32_t filtered = 0;  ///< of these, pairs that a collision filter excludes
  std::uint32_t left = 0;      ///< of these, pairs that may collide all the same: with filters 0
  std::uint32_t trimmed = 0;   ///< bodies with a trimmed hull
  std::uint32_t systems = 0;   ///< collision systems, at most 32
  double deepest = 0;          ///< m: the deepest overlap of two bodies that may collide; 0: none overlap
  double tolerance = 0;        ///< m
  double least_share = 1;      ///< of its volume that a trimmed hull kept, at least
  bool operator==(const RestFigures&) const = default;
};

/// A companion of a FragmentSet with hulls.
struct Rest {
  RestFigures figures;
  CollisionFilters filters;  ///< by fragment
  /// Ids of two fragments that must not collide, in the order of the answer: of a delta those with a new or changed one.
  std::vector<std::array<std::uint64_t, 2>> filtered;
  bool trimmed_for_filters = false;  ///< hulls were trimmed because filters ran out
};

/// `tolerance`: m. Does not change the hulls: trimmed_for_filters says that they would have to be. Throws Interrupted.
Rest find_rest(const Bodies& bodies, const CellsOfBodies& cells, double tolerance, HullFilters filters,
               const Execution& execution);

/// The same of a whole set, whose hulls are trimmed if filters run out.
Rest bring_to_rest(const FragmentSet& set, CollisionHulls& hulls, const CellsOfBodies& cells,
                   double tolerance, HullFilters filters, const Execution& execution);

}  // namespace fracture
