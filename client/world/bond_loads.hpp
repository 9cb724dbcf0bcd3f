// How forces spread through a group of bonded fragments, and which of its bonds they break.
//
// The model: every bond is a spring with the stiffness area / distance in all three directions (so that equal
// material gives equal stress); fragments shift, they do not turn. For the forces f on the fragments, the
// shifts u solve the graph Laplacian  Σ_j k_ij (u_j − u_i) = m_i a_i − f_i − m_i g.  A group without anchors
// accelerates as the rigid body that it is (inertia relief: a_i = g + F/M + α × r_i, quasi-static); one with
// anchors does not move, and its anchors have u = 0. The force of a bond is k (u_b − u_a): its part along the
// normal is tension or compression, the rest shear. (Shear and pull are carried from fragment to fragment;
// bending, which needs fragments that turn, is not.)
//
// A hit is over before the far end feels it. While it lasts (τ), the mass near the hit resists it: one implicit
// step of  M ü + K u = f  over τ adds m_i / τ² to the diagonal. We set K = ρ c² area / distance (c: speed of
// sound) and divide by ρ c²; the term becomes volume_i / reach², reach = c τ. The force dies away over this
// length. Without the term all of it would reach the anchors and shear off every wall at its foot.
//
// A bond breaks where sqrt(pull² + shear²) · kStressConcentration > strength. Compression counts as an eighth
// of a pull: brittle solids bear about eight times as much when they are pressed (Griffith, "The Theory of
// Rupture", 1924).
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "client/world/fragments.hpp"

namespace fracture::world {

/// The file states the strength of sound material under even stress. Cracks start at notches and at the point
/// of contact, where the stress is some ten times the mean that this network computes. With a larger factor
/// everything breaks at a touch; with 1 a thrown ball breaks no stone.
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
  Forces hits{};                           ///< over within the contact time
  double reach = 0.5;                      ///< metres, of hits
  glm::dvec3 gravity{0};                   ///< m/s², in the asset's frame
};

/// Load divided by strength for each bond of the case: more than 1 breaks. A bond of strength 0 under any
/// load: a large number.
std::vector<double> bond_loads(const FragmentSet& set, const LoadCase& load);

/// Connected components of the members under the bonds: each sorted, the one with the lowest member first.
std::vector<std::vector<std::uint32_t>> components(std::span<const std::uint32_t> members,
                                                   std::span<const std::uint32_t> bonds,
                                                   const FragmentSet& set);

}  // namespace fracture::world
