// Mass, centre and inertia of rigid bodies, and how they add up; momentum of a set of bodies.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <span>

namespace fracture::world {

/// In some frame: kilograms, metres, kg·m² about the centre along the frame's axes.
struct MassProperties {
  double mass = 0;
  glm::dvec3 center{0};
  glm::dmat3 inertia{0};

  /// The same body seen from another frame: rotated, then moved.
  MassProperties moved(const glm::dquat& rotation, const glm::dvec3& translation) const;
};

/// Of all of them as one rigid body (Huygens–Steiner).
MassProperties combine(std::span<const MassProperties> parts);

/// Inertia of a body as if all of `mass` stood at `offset` from the centre.
glm::dmat3 point_inertia(double mass, const glm::dvec3& offset);

/// inertia = R diag(moments) Rᵀ, moments > 0 ascending, R a rotation (Jacobi's method).
struct PrincipalAxes {
  glm::dvec3 moments{1};
  glm::dquat rotation{1, 0, 0, 0};
};
PrincipalAxes principal_axes(const glm::dmat3& inertia);

/// Of a solid bounded by triangles, by the divergence theorem (Mirtich, "Fast and Accurate Computation of
/// Polyhedral Mass Properties", 1996, as sums over tetrahedra with the origin). Volume 0 or less (an open or
/// inverted mesh): that of the box around it.
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

/// Adds the one rigid motion to all bodies after which they have that momentum, about their own common
/// centre.
void set_momentum(std::span<Motion> bodies, const glm::dvec3& linear, const glm::dvec3& angular);

}  // namespace fracture::world
