// Records what is seen and heard in a step. Only reads the world.
#include <algorithm>
#include <cmath>

#include "client/world/state.hpp"

namespace fracture::world {
namespace {

/// Slower contacts are those of resting things: no sound, no dust.
constexpr double kAudibleSpeed = 0.15;  // m/s
/// A contact counts as a knock for this many steps; after that it carries weight.
constexpr int kYoungSteps = 2;

glm::dvec3 speed_at(const Body& body, const glm::dvec3& point) {
  if (!body.moves()) return glm::dvec3(0);
  return body.velocity_before +
         glm::cross(body.spin_before, point - from_bullet(body.rigid->getCenterOfMassPosition()));
}

Knock::Side side_of(const Body& body, int child) {
  Knock::Side side;
  if (body.kind == Body::Kind::kGround || body.kind == Body::Kind::kStatic) return side;
  side.mass = body.mass.mass;
  side.moments = principal_axes(body.mass.inertia).moments;
  side.held = body.held;
  if (body.kind == Body::Kind::kBall) {
    side.kind = Knock::Side::Kind::kBall;
    return side;
  }
  side.kind = Knock::Side::Kind::kObject;
  side.object = body.object;
  if (body.kind == Body::Kind::kGroup) {
    const auto k = static_cast<std::size_t>(child);
    side.fragment =
        child >= 0 && k < body.fragment_of_child.size() ? body.fragment_of_child[k] : body.members[0];
  }
  return side;
}

}  // namespace

void World::State::witness_knocks() {
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    if (witnessed.knocks.size() >= settings.max_witnessed) return;
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
    const auto* first = static_cast<const Body*>(manifold.getBody0()->getUserPointer());
    const auto* second = static_cast<const Body*>(manifold.getBody1()->getUserPointer());
    if (first == nullptr || second == nullptr || first->gone || second->gone) continue;
    Knock knock;
    int child_a = -1, child_b = -1;
    double strongest = 0;
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      const double impulse = point.m_appliedImpulse;
      if (!(impulse > 0) || point.getLifeTime() > kYoungSteps) continue;
      const glm::dvec3 where = from_bullet(point.getPositionWorldOnB()),
                       normal = from_bullet(point.m_normalWorldOnB);
      const double approach = -glm::dot(speed_at(*first, where) - speed_at(*second, where), normal);
      if (!(approach > kAudibleSpeed)) continue;
      knock.point += impulse * where;
      knock.impulse += impulse;
      knock.approach = std::max(knock.approach, approach);
      if (impulse <= strongest) continue;
      strongest = impulse;
      knock.normal = normal;
      child_a = point.m_index0;
      child_b = point.m_index1;
    }
    if (!(knock.impulse > 0)) continue;
    knock.step = steps;
    knock.point /= knock.impulse;
    knock.a = side_of(*first, child_a);
    knock.b = side_of(*second, child_b);
    witnessed.knocks.push_back(knock);
  }
}

void World::State::witness_cracks() {
  if (settings.max_witnessed == 0) return;
  for (std::size_t id = 0; id < objects.size(); ++id) {
    Object& object = *objects[id];
    if (!object.fragments) continue;
    const FragmentSet& set = object.fragments->set;
    object.cracked.resize(object.bond_load.size(), false);
    for (std::size_t k = 0; k < object.bond_load.size(); ++k) {
      if (object.bond_load[k] >= 0 || object.cracked[k]) continue;
      object.cracked[k] = true;
      if (witnessed.cracks.size() >= settings.max_witnessed) continue;
      const Bond& bond = set.bonds[k];
      const Body* body = object.body_of[bond.a] != nullptr ? object.body_of[bond.a] : object.body_of[bond.b];
      if (body == nullptr) continue;
      const Pose pose = body->asset_to_world();
      const MassProperties &a = set.fragments[bond.a].mass, &b = set.fragments[bond.b].mass;
      const MassProperties& light = a.mass < b.mass ? a : b;
      const glm::dvec3 point = pose.point(bond.center);
      glm::dvec3 velocity(0);
      if (body->moves())
        velocity = from_bullet(
            body->rigid->getVelocityInLocalPoint(to_bullet(point) - body->rigid->getCenterOfMassPosition()));
      witnessed.cracks.push_back({.step = steps,
                                  .object = static_cast<ObjectId>(id),
                                  .bond = static_cast<std::uint32_t>(k),
                                  .point = point,
                                  .normal = pose.rotation * bond.normal,
                                  .area = bond.area,
                                  .strength = bond.strength,
                                  .velocity = velocity,
                                  .mass = light.mass,
                                  .moments = principal_axes(light.inertia).moments});
    }
  }
}

}  // namespace fracture::world
