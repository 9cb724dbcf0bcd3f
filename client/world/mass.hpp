// Mass, centre and inertia of rigid bodies, and their combination; momentum of a set of bodies.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <span>

namespace fracture::world {

/// Mass (kg), centre (m), and inertia (kg·m²) about the centre, along the axes of some frame.
struct MassProperties {
  double mass = 0;
  glm::dvec3 center{0};
  glm::dmat3 inertia{0};

  /// The same body in another frame: rotated, then translated.
  MassProperties moved(const glm::dquat& rotation, const glm::dvec3& translation) const;
};

/// All parts as one rigid body (Huygens–Steiner).
MassProperties combine(std::span<const MassProperties> parts);

/// Inertia about the centre if all of `mass` were at `offset` from it.
glm::dmat3 point_inertia(double mass, const glm::dvec3& offset);

/// inertia = R diag(moments) Rᵀ, with positive ascending moments and a rotation R (Jacobi's method).
struct PrincipalAxes {
  glm::dvec3 moments{1};
  glm::dquat rotation{1, 0, 0, 0};
};
PrincipalAxes principal_axes(const glm::dmat3& inertia);

/// Properties of a solid bounded by triangles, by the divergence theorem (Mirtich, "Fast and Accurate
/// Computation of Polyhedral Mass Properties", 1996, as sums over tetrahedra with the origin). If the volume
/// is 0 or less (an open or inverted mesh), those of its bounding box.
MassProperties solid_mass(std::span<const glm::vec3> positions,
                          std::span<const std::array<std::uint32_t, 3>> triangles, double density);

/// A rigid body in the world.
struct Motion {
  MassProperties mass;  ///< centre in the world, inertia along the world's axes
  glm::dvec3 velocity{0}, spin{0};
};

struct Momentum {
  double mass = 0;
  glm::dvec3 linear{0};   ///< kg·m/s
  glm::dvec3 angular{0};  ///< kg·m²/s about the common centre of mass
  glm::dvec3 center{0};
};
Momentum momentum(std::span<const Motion> bodies);

/// Adds one rigid motion to all bodies so that they have this momentum about their own common centre.
void set_momentum(std::span<Motion> bodies, const glm::dvec3& linear, const glm::dvec3& angular);

}  // namespace fracture::world
