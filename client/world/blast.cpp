// An explosion: an impulse on everything around a point, away from it.
//
// Nothing shields a body from the blast. Each body takes a share of the impulse equal to its share of all
// directions around the point. A ball of radius r at distance d fills the solid angle 2π (1 − cos θ) of 4π,
// with sin θ = r / d. At the point itself, it fills half of all directions. So large bodies are pushed harder
// and distant ones less. The share falls to zero at the blast's radius.
#include <algorithm>
#include <cmath>

#include "client/world/state.hpp"

namespace fracture::world {
namespace {

/// m/s: a body gets no faster than the gas that pushes it, however many blasts there are. Otherwise a small
/// body nearby would fly off like a bullet.
constexpr double kGasSpeed = 20;

/// Radius of the solid ball with the same mass and the same sum of moments, 3 · 2/5 m r².
double radius_of(const MassProperties& mass) {
  const double sum = mass.inertia[0][0] + mass.inertia[1][1] + mass.inertia[2][2];
  return std::sqrt(std::max(sum, 0.0) / (1.2 * std::max(mass.mass, 1e-12)));
}

/// N·s. Blast and body are given in the same frame.
glm::dvec3 impulse_on(const Blast& blast, const MassProperties& body) {
  const glm::dvec3 away = body.center - blast.point;
  const double distance = glm::length(away), radius = radius_of(body);
  const double fall = 1 - std::max(0.0, distance - radius) / blast.radius;
  if (!(fall > 0)) return glm::dvec3(0);
  const double sine = distance > radius ? radius / distance : 1;
  const double share = 0.5 * (1 - std::sqrt(std::max(0.0, 1 - sine * sine)));
  const double size = std::min(share * fall * blast.impulse, kGasSpeed * body.mass);
  return size * (distance > 1e-9 ? away / distance : glm::dvec3(0, 1, 0));
}

Blast moved(const Blast& blast, const glm::dvec3& point) { return {point, blast.impulse, blast.radius}; }

}  // namespace

void World::State::push(Body& body, const Blast& blast) {
  if (!body.is_loose() || body.gone) return;
  const glm::dvec3 impulse = impulse_on(blast, body.motion().mass);
  if (impulse == glm::dvec3(0)) return;
  wake(body);
  const glm::dvec3 velocity = from_bullet(body.rigid->getLinearVelocity()), away = glm::normalize(impulse);
  const double along = glm::dot(velocity, away),
               gained = std::min(glm::length(impulse) / body.mass.mass, std::max(0.0, kGasSpeed - along));
  const double before = kinetic_energy(body);
  set_motion(body, velocity + gained * away, from_bullet(body.rigid->getAngularVelocity()));
  body.rigid->activate(true);
  body.lively = std::max(body.lively, gained);
  body.still = body.quiet = body.asleep = 0;
  ledger.brought += kinetic_energy(body) - before;
}

std::vector<PointForce> World::State::forces_of(const Blast& blast, const FragmentSet& set,
                                                std::span<const std::uint32_t> members) const {
  std::vector<PointForce> forces;
  for (const std::uint32_t m : members) {
    const MassProperties& mass = set.fragments[m].mass;
    const glm::dvec3 impulse = impulse_on(blast, mass);
    if (impulse != glm::dvec3(0))
      forces.push_back({m, impulse / settings.contact_time, mass.center, true, Cause::kBlast});
  }
  return forces;
}

/// A whole object that the blast would break gets the impulse once it is in pieces. Until then, its motion
/// does not change.
void World::State::blast_whole(Body& body, const Blast& blast) {
  Object& object = *objects[body.object];
  const Pose pose = body.asset_to_world();
  const Blast there = moved(blast, pose.local(blast.point));
  const glm::dvec3 impulse = impulse_on(there, body.mass);
  const double size = glm::length(impulse);
  if (size <= object.spec.strength) return push(body, blast);
  if (!object.hit()) {
    object.hit_at = steps;
    object.hit_by = Cause::kBlast;
  }
  object.blasts.push_back(there);
  if (object.asked) return;
  object.asked = true;
  // The hit is at the nearest point of its bounding box.
  glm::dvec3 low(HUGE_VAL), high(-HUGE_VAL);
  for (const Hull& hull : object.spec.hulls)
    for (const glm::dvec3& p : hull) {
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
  const glm::dvec3 point = glm::clamp(there.point, low, high);
  events.push_back({Event::Kind::kBreak,
                    body.object,
                    0,
                    {point, impulse / size, size, 0.5 * size * kGasSpeed},
                    pose.point(point)});
}

void World::State::blast_group(Body& body, const Blast& blast) {
  Object& object = *objects[body.object];
  const Pose pose = body.asset_to_world();
  const FragmentSet& set = object.fragments->set;
  const std::vector<PointForce> forces = forces_of(moved(blast, pose.local(blast.point)), set, body.members);
  if (forces.empty() || body.bonds.empty()) return push(body, blast);
  if (object.guarded) {
    glm::dvec3 sum(0);
    for (const PointForce& f : forces) sum += settings.contact_time * f.force;
    if (glm::length(sum) <= object.spec.strength) return push(body, blast);
    object.guarded = false;
  }
  const glm::dvec3 gravity = glm::conjugate(pose.rotation) * settings.gravity;
  if (break_bonds(object, body.members, body.bonds, forces, gravity) == 0) return push(body, blast);
  if (std::exchange(object.sound, false)) breaks.push_back({steps, body.object, Cause::kBlast, 0});
  const std::size_t first = bodies.size();
  split(body);
  if (!body.gone) push(body, blast);
  for (std::size_t k = first; k < bodies.size(); ++k) push(*bodies[k], blast);
}

void World::explode(const Blast& blast) {
  State& s = *state_;
  if (!(blast.impulse > 0) || !(blast.radius > 0)) return;
  const std::size_t count = s.bodies.size();  // new pieces are appended after these
  for (std::size_t k = 0; k < count; ++k) {
    Body& body = *s.bodies[k];
    if (body.gone) continue;
    switch (body.kind) {
      case Body::Kind::kWhole:
        s.blast_whole(body, blast);
        break;
      case Body::Kind::kGroup:
        s.blast_group(body, blast);
        break;
      case Body::Kind::kBall:
        s.push(body, blast);
        break;
      case Body::Kind::kGround:
      case Body::Kind::kStatic:
        break;
    }
  }
  s.sweep_out();
}

std::optional<glm::dvec3> World::first_met(const glm::dvec3& from, const glm::dvec3& to) const {
  btCollisionWorld::ClosestRayResultCallback ray(to_bullet(from), to_bullet(to));
  state_->bullet.rayTest(to_bullet(from), to_bullet(to), ray);
  if (!ray.hasHit()) return std::nullopt;
  return from_bullet(ray.m_hitPointWorld);
}

}  // namespace fracture::world
