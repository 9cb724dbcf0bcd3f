// Reads bodies, hulls and bonds from the service's answer (KHR_physics_rigid_bodies and extras.fracture of the
// GLB) and checks them. Computes none of them itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "client/world/mass.hpp"
#include "common/base/error.hpp"

namespace fracture::world {

/// Points of a convex hull, in the frame of the asset (the mesh that was fractured), metres.
using Hull = std::vector<glm::dvec3>;

struct Fragment {
  std::uint64_t id = 0;
  double volume = 0;    ///< m³, > 0
  MassProperties mass;  ///< in the frame of the asset
  std::vector<Hull> hulls;
  bool anchored = false;
  int system = -1;  ///< fragments of one system do not collide with one another; -1: none
  /// A later hit has put others in its place (change.hpp). It stays in the set, so that the others keep their numbers.
  bool gone = false;
};

struct Bond {
  std::uint32_t a = 0, b = 0;  ///< indices of fragments
  double area = 0;             ///< m²
  double strength = 0;         ///< newtons
  glm::dvec3 normal{0};        ///< unit length, from a to b; zero where the two share no plane
  glm::dvec3 center{0};        ///< of what they share, in the frame of the asset
  bool gone = false;           ///< of a fragment that a later hit changed or took away
};

struct FragmentSet {
  std::vector<Fragment> fragments;
  std::vector<Bond> bonds;
  double friction = 0.6, restitution = 0.1;
};

/// What a hit changed of an earlier answer, as an answer with delta=only says it.
struct FragmentChange {
  std::vector<Fragment> fragments;                  ///< those that are new and those that changed
  std::vector<std::uint64_t> added, changed, gone;  ///< ids; the last are not among `fragments`
  struct End {
    std::uint64_t a = 0, b = 0;  ///< ids, also of fragments that the hit left as they were
  };
  std::vector<Bond>
      bonds;  ///< of the fragments here, with one another and with those that stay; `a` and `b` unset
  std::vector<End> ends;  ///< of each bond
};

inline constexpr std::size_t kMaxFragments = 20'000;  ///< of one answer, for physics

/// kMalformedMesh (what is missing or contradicts itself: unknown ids in bonds, indices out of range, a body
/// without mass or hull), kNotFinite (NaN or infinite numbers), kTooLarge, kNoFragments, and what
/// common/import refuses.
Expected<FragmentSet> read_fragments(std::span<const std::byte> glb);

/// The same for an answer with delta=only; kMalformedMesh also where it does not say what has changed, or has other
/// fragments than it says.
Expected<FragmentChange> read_change(std::span<const std::byte> glb);

}  // namespace fracture::world
