#include "client/world/mass.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fracture::world {

glm::dmat3 point_inertia(double mass, const glm::dvec3& r) {
  return mass * (glm::dot(r, r) * glm::dmat3(1) - glm::outerProduct(r, r));
}

MassProperties MassProperties::moved(const glm::dquat& rotation, const glm::dvec3& translation) const {
  const glm::dmat3 r = glm::mat3_cast(rotation);
  return {mass, rotation * center + translation, r * inertia * glm::transpose(r)};
}

MassProperties combine(std::span<const MassProperties> parts) {
  MassProperties whole;
  for (const MassProperties& part : parts) {
    whole.mass += part.mass;
    whole.center += part.mass * part.center;
  }
  if (whole.mass > 0) whole.center /= whole.mass;
  for (const MassProperties& part : parts)
    whole.inertia += part.inertia + point_inertia(part.mass, part.center - whole.center);
  return whole;
}

PrincipalAxes principal_axes(const glm::dmat3& inertia) {
  glm::dmat3 a = inertia, v(1);  // a[column][row]
  for (int sweep = 0; sweep < 30; ++sweep) {
    const double off = a[1][0] * a[1][0] + a[2][0] * a[2][0] + a[2][1] * a[2][1];
    const double scale = a[0][0] * a[0][0] + a[1][1] * a[1][1] + a[2][2] * a[2][2];
    if (off <= 1e-32 * scale) break;
    for (const auto& [p, q] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
      if (a[q][p] == 0) continue;
      const double theta = (a[q][q] - a[p][p]) / (2 * a[q][p]);
      const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1));
      const double c = 1 / std::sqrt(t * t + 1), s = t * c;
      glm::dmat3 turn(1);
      turn[p][p] = turn[q][q] = c;
      turn[q][p] = s;
      turn[p][q] = -s;
      a = glm::transpose(turn) * a * turn;
      v = v * turn;
    }
  }
  std::array<int, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int i, int k) { return a[i][i] < a[k][k]; });
  glm::dmat3 axes(v[order[0]], v[order[1]], v[order[2]]);
  if (glm::determinant(axes) < 0) axes[2] = -axes[2];
  return {{a[order[0]][order[0]], a[order[1]][order[1]], a[order[2]][order[2]]},
          glm::normalize(glm::quat_cast(axes))};
}

MassProperties solid_mass(std::span<const glm::vec3> positions,
                          std::span<const std::array<std::uint32_t, 3>> triangles, double density) {
  glm::dvec3 low(HUGE_VAL), high(-HUGE_VAL);
  for (const glm::vec3& p : positions) {
    low = glm::min(low, glm::dvec3(p));
    high = glm::max(high, glm::dvec3(p));
  }
  if (positions.empty()) low = high = glm::dvec3(0);
  const glm::dvec3 origin = 0.5 * (low + high);  // near the solid, to keep precision
  double volume = 0;
  glm::dvec3 first(0);
  glm::dmat3 second(0);  // ∫ x xᵀ
  for (const auto& t : triangles) {
    const glm::dvec3 a = glm::dvec3(positions[t[0]]) - origin, b = glm::dvec3(positions[t[1]]) - origin,
                     c = glm::dvec3(positions[t[2]]) - origin;
    const double six = glm::dot(a, glm::cross(b, c));
    volume += six / 6;
    first += six / 24 * (a + b + c);
    const glm::dvec3 sum = a + b + c;
    second += six / 120 *
              (glm::outerProduct(a, a) + glm::outerProduct(b, b) + glm::outerProduct(c, c) +
               glm::outerProduct(sum, sum));
  }
  const glm::dvec3 size = high - low;
  const double box = size.x * size.y * size.z;
  if (!(volume > 1e-6 * box)) {
    const double mass = density * std::max(box, 1e-9);
    const glm::dvec3 s = glm::max(size * size, glm::dvec3(1e-6));
    return {mass, origin, mass / 12 * glm::dmat3(s.y + s.z, 0, 0, 0, s.x + s.z, 0, 0, 0, s.x + s.y)};
  }
  const glm::dvec3 center = first / volume;
  second -= volume * glm::outerProduct(center, center);
  const double trace = second[0][0] + second[1][1] + second[2][2];
  return {density * volume, center + origin, density * (trace * glm::dmat3(1) - second)};
}

Momentum momentum(std::span<const Motion> bodies) {
  Momentum sum;
  for (const Motion& body : bodies) {
    sum.mass += body.mass.mass;
    sum.center += body.mass.mass * body.mass.center;
    sum.linear += body.mass.mass * body.velocity;
  }
  if (sum.mass > 0) sum.center /= sum.mass;
  for (const Motion& body : bodies)
    sum.angular += body.mass.inertia * body.spin +
                   body.mass.mass * glm::cross(body.mass.center - sum.center, body.velocity);
  return sum;
}

void set_momentum(std::span<Motion> bodies, const glm::dvec3& linear, const glm::dvec3& angular) {
  const Momentum now = momentum(bodies);
  if (!(now.mass > 0)) return;
  glm::dmat3 inertia(0);
  for (const Motion& body : bodies)
    inertia += body.mass.inertia + point_inertia(body.mass.mass, body.mass.center - now.center);
  const glm::dvec3 velocity = (linear - now.linear) / now.mass;
  const glm::dvec3 spin = glm::inverse(inertia) * (angular - now.angular);
  for (Motion& body : bodies) {
    body.velocity += velocity + glm::cross(spin, body.mass.center - now.center);
    body.spin += spin;
  }
}

}  // namespace fracture::world
