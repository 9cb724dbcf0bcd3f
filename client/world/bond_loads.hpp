// Spreads forces through a group of bonded fragments and finds the bonds that they break.
//
// The model: every bond is a spring with the stiffness area / distance in all three directions, so that equal
// material gives equal stress. Fragments shift but do not turn. For the forces f on the fragments, the shifts
// u solve the graph Laplacian  Σ_j k_ij (u_j − u_i) = m_i a_i − f_i − m_i g.  A group without anchors
// accelerates as a rigid body (inertia relief: a_i = g + F/M + α × r_i, quasi-static). A group with anchors
// does not move, and its anchors have u = 0. The force of a bond is k (u_b − u_a): its part along the normal
// is tension or compression, the rest shear. (Shear and tension pass from fragment to fragment. Bending does
// not, because fragments do not turn.)
//
// A hit ends before the far end feels it. While it lasts (τ), the mass near the hit resists it: one implicit
// step of M ü + K u = f  over τ adds m_i / τ² to the diagonal. We set K = ρ c² area / distance (c: speed of
// sound) and divide by ρ c². The term becomes volume_i / reach², with reach = c τ, and the force decays over
// this length. Without the term, the whole force would reach the anchors and shear off every wall at its
// foot.
//
// A bond breaks if sqrt(tension² + shear²) · kStressConcentration > strength. Compression counts as an eighth
// of a tension, because brittle solids bear about eight times as much in compression (Griffith, "The Theory
// of Rupture", 1924).
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "client/world/fragments.hpp"

namespace fracture::world {

/// The file states the strength of flawless material under even stress. Cracks start at notches and at the
/// point of contact, where the stress is about ten times the mean that this network computes. With a larger
/// factor, everything breaks at a touch. With 1, a thrown ball breaks no stone.
inline constexpr double kStressConcentration = 25;
inline constexpr double kCompressionShare = 1.0 / 8;
/// Forces on the members, in the asset's frame; empty: none.
struct Forces {
  std::vector<glm::dvec3> on_member;  ///< N
  glm::dvec3 torque{0};               ///< about the group's centre of mass, N·m
};

struct LoadCase {
  std::span<const std::uint32_t> members;  ///< fragments of the group, ascending
  std::span<const std::uint32_t> bonds;    ///< unbroken bonds among them
  Forces lasting{};                        ///< without gravity
  Forces hits{};                           ///< end within the contact time
  double reach = 0.5;                      ///< metres, of hits
  glm::dvec3 gravity{0};                   ///< m/s², in the asset's frame
};

/// Load divided by strength for each bond of the case: it breaks above 1. A loaded bond of strength 0 gives a
/// large number.
std::vector<double> bond_loads(const FragmentSet& set, const LoadCase& load);

/// Connected components of the members under the bonds. Each is sorted; the component with the lowest member
/// comes first.
std::vector<std::vector<std::uint32_t>> components(std::span<const std::uint32_t> members,
                                                   std::span<const std::uint32_t> bonds,
                                                   const FragmentSet& set);

}  // namespace fracture::world
