// Keeps the run's own physics statistics: see Ledger in world.hpp.
#include <algorithm>

#include "client/world/state.hpp"

namespace fracture::world {

double kinetic_energy(const Body& body) {
  if (!body.moves()) return 0;
  const btRigidBody& rigid = *body.rigid;
  const btVector3 spin = rigid.getWorldTransform().getBasis().transpose() * rigid.getAngularVelocity(),
                  inertia = rigid.getLocalInertia();
  return 0.5 * (body.mass.mass * rigid.getLinearVelocity().length2() + (spin * inertia).dot(spin));
}

double World::State::height(const Body& body) const {
  return -glm::dot(settings.gravity, from_bullet(body.rigid->getWorldTransform().getOrigin()));
}

double World::State::energy(const Body& body) const {
  if (body.kind == Body::Kind::kGround || body.kind == Body::Kind::kStatic) return 0;
  return kinetic_energy(body) + body.mass.mass * height(body);
}

void World::State::keep_ledger() {
  ledger.energy = 0;
  for (const auto& object : objects) ledger.energy += object->stored;
  bool asleep = true;
  for (const auto& body : bodies) {
    if (body->gone) continue;
    ledger.energy += energy(*body);
    if (body->kind != Body::Kind::kGroup || body->held) continue;
    if (body->rigid->isActive()) asleep = false;
    const Pose pose = body->asset_to_world();
    if (pose.point(body->mass.center).y - body->radius >= -ledger.deepest) continue;
    for (const std::uint32_t m : body->members)
      ledger.deepest = std::max(
          ledger.deepest, -pose.point(objects[body->object]->fragments->set.fragments[m].mass.center).y);
  }
  // Bullet wakes approaching bodies before they touch.
  constexpr std::uint64_t kNear = 12;  // steps
  if (!asleep && ledger.asleep_since) awake_since = steps;
  if (awake_since && steps <= *awake_since + kNear && knocked) {
    ledger.last_woken = *awake_since;
    awake_since = std::nullopt;
  }
  if (!asleep)
    ledger.asleep_since = std::nullopt;
  else if (!ledger.asleep_since)
    ledger.asleep_since = steps;
  least_level = std::min(least_level, ledger.energy - ledger.brought);
  ledger.worst_gain = std::max(ledger.worst_gain, ledger.energy - ledger.brought - least_level);
}

}  // namespace fracture::world
