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
};

struct Bond {
  std::uint32_t a = 0, b = 0;  ///< indices of fragments
  double area = 0;             ///< m²
  double strength = 0;         ///< newtons
  glm::dvec3 normal{0};        ///< unit length, from a to b; zero where the two share no plane
  glm::dvec3 center{0};        ///< of what they share, in the frame of the asset
};

struct FragmentSet {
  std::vector<Fragment> fragments;
  std::vector<Bond> bonds;
  double friction = 0.6, restitution = 0.1;
};

inline constexpr std::size_t kMaxFragments = 20'000;  ///< of one answer, for physics

/// kMalformedMesh (what is missing or contradicts itself: unknown ids in bonds, indices out of range, a body
/// without mass or hull), kNotFinite (NaN or infinite numbers), kTooLarge, kNoFragments, and what
/// common/import refuses.
Expected<FragmentSet> read_fragments(std::span<const std::byte> glb);

}  // namespace fracture::world
