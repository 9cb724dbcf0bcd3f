// Reads bodies, hulls and bonds from the service's answer (KHR_physics_rigid_bodies and the GLB's
// extras.fracture) and checks them. It computes none of them.
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
  /// The ids of fragments that overlap it and must not collide with it, ascending.
  std::vector<std::uint64_t> apart{};
  /// A later hit has replaced it by others (change.hpp). It stays in the set so that the others keep their
  /// numbers.
  bool gone = false;
};

struct Bond {
  std::uint32_t a = 0, b = 0;  ///< indices of fragments
  double area = 0;             ///< m²
  double strength = 0;         ///< newtons
  glm::dvec3 normal{0};        ///< unit length, from a to b; zero if the two share no plane
  glm::dvec3 center{0};        ///< centre of the shared face, in the frame of the asset
  bool gone = false;           ///< a later hit changed or removed one of its fragments
};

struct FragmentSet {
  std::vector<Fragment> fragments;
  std::vector<Bond> bonds;
  double friction = 0.6, restitution = 0.1;
};

/// The changes that a hit made to an earlier answer: the content of an answer with delta=only.
struct FragmentChange {
  std::vector<Fragment> fragments;                  ///< new and changed fragments
  std::vector<std::uint64_t> added, changed, gone;  ///< ids; those in `gone` are not in `fragments`
  struct End {
    std::uint64_t a = 0, b = 0;  ///< ids, possibly of fragments that the hit did not change
  };
  /// The bonds of these fragments with one another and with unchanged ones; `a` and `b` are not set
  std::vector<Bond> bonds;
  std::vector<End> ends;  ///< of each bond, in the same order
};

inline constexpr std::size_t kMaxFragments = 20'000;  ///< limit per answer, for physics

/// kMalformedMesh if something is missing or contradictory (unknown ids in bonds, indices out of range, a
/// body without mass or hull). Also kNotFinite (NaN or infinite numbers), kTooLarge, kNoFragments, and the
/// errors of common/import.
Expected<FragmentSet> read_fragments(std::span<const std::byte> glb);

/// Reads an answer with delta=only. Errors are as for read_fragments(). kMalformedMesh also means that the
/// answer does not list its changes, or that its fragments are not those listed.
Expected<FragmentChange> read_change(std::span<const std::byte> glb);

}  // namespace fracture::world
