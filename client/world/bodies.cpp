// Creates, removes and fades bodies.
#include <algorithm>
#include <optional>
#include <vector>

#include "client/world/state.hpp"

namespace fracture::world {

Motion Body::motion() const {
  const Pose pose = asset_to_world();
  return {mass.moved(pose.rotation, pose.position), from_bullet(rigid->getLinearVelocity()),
          from_bullet(rigid->getAngularVelocity())};
}

void set_motion(Body& body, const glm::dvec3& velocity, const glm::dvec3& spin) {
  body.rigid->setLinearVelocity(to_bullet(velocity));
  body.rigid->setAngularVelocity(to_bullet(spin));
  body.rigid->setInterpolationLinearVelocity(to_bullet(velocity));
  body.rigid->setInterpolationAngularVelocity(to_bullet(spin));
}

Body& World::State::add(std::unique_ptr<Body> body, btCollisionShape* shape, const PrincipalAxes& axes,
                        const Pose& pose, double friction, double restitution) {
  const bool moves = body->moves();
  btRigidBody::btRigidBodyConstructionInfo info(moves ? body->mass.mass : 0, nullptr, shape,
                                                moves ? to_bullet(axes.moments) : btVector3(0, 0, 0));
  info.m_startWorldTransform = to_bullet(pose);
  info.m_friction = friction;
  info.m_restitution = restitution;
  // calm() decides which bodies rest. Bullet's own thresholds would wake a whole heap for one small shard
  // that turns slowly.
  info.m_linearSleepingThreshold = info.m_angularSleepingThreshold = 1e6;
  info.m_angularDamping = moves ? 0.04 : 0;
  body->rigid = std::make_unique<btRigidBody>(info);
  body->rigid->setUserPointer(body.get());
  if (body->kind != Body::Kind::kBall) {
    btVector3 center;
    btScalar radius = 0;
    shape->getBoundingSphere(center, radius);
    body->radius = radius;
  }
  body->number = next_body++;
  bullet.addRigidBody(body->rigid.get());
  bodies.push_back(std::move(body));
  return *bodies.back();
}

Body& World::State::add_group(ObjectId object, std::vector<std::uint32_t> members,
                              std::vector<std::uint32_t> bonds, const Pose& asset_to_world) {
  Object& owner = *objects[object];
  const PreparedFragments& prepared = *owner.fragments;
  auto body = std::make_unique<Body>();
  body->kind = Body::Kind::kGroup;
  body->object = object;
  body->group = next_group++;
  body->born = steps;
  std::vector<MassProperties> masses;
  for (const std::uint32_t m : members) {
    masses.push_back(prepared.set.fragments[m].mass);
    body->held = body->held || prepared.set.fragments[m].anchored;
  }
  body->mass = combine(masses);
  if (!body->held) ++live;
  body->crumb = members.size() == 1 && !body->held && live > settings.live_bodies &&
                prepared.set.fragments[members[0]].volume < settings.debris_share * prepared.volume;
  PrincipalAxes axes;
  btCollisionShape* shape = nullptr;
  if (members.size() == 1 && prepared.parts[members[0]].hulls.size() == 1) {
    const PreparedFragments::Part& part = prepared.parts[members[0]];
    axes = {part.moments, part.frame.rotation};
    body->local = part.frame;
    shape = part.hulls[0].get();
    body->fragment_of_child = {members[0]};
  } else {
    axes = principal_axes(body->mass.inertia);
    body->local = {body->mass.center, axes.rotation};
    std::size_t count = 0;
    for (const std::uint32_t m : members) count += prepared.parts[m].hulls.size();
    auto compound = std::make_unique<btCompoundShape>(true, static_cast<int>(count));
    const Pose to_body = inverse(body->local);
    for (const std::uint32_t m : members)
      for (const auto& hull : prepared.parts[m].hulls) {
        compound->addChildShape(to_bullet(to_body * prepared.parts[m].frame), hull.get());
        body->fragment_of_child.push_back(m);
      }
    shape = compound.get();
    body->shape = std::move(compound);
  }
  body->members = std::move(members);
  body->bonds = std::move(bonds);
  const Pose pose = asset_to_world * body->local;
  Body& added = add(std::move(body), shape, axes, pose, prepared.set.friction, prepared.set.restitution);
  for (const std::uint32_t m : added.members) owner.body_of[m] = &added;
  return added;
}

void World::State::remove(Body& body) {
  if (body.gone) return;
  body.gone = true;
  bullet.removeRigidBody(body.rigid.get());
}

void World::State::sweep_out() {
  std::erase_if(bodies, [](const std::unique_ptr<Body>& body) { return body->gone; });
}

/// Numbers of the bodies that support another one, ascending.
std::vector<std::uint64_t> World::State::bearers() {
  std::vector<std::uint64_t> found;
  for (const auto& body : bodies)
    for (const Body::Touched& other : body->touched)
      if (other.bears) found.push_back(other.number);
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
    if (const Body* lower = bearer(manifold)) found.push_back(lower->number);
  }
  std::sort(found.begin(), found.end());
  return found;
}

void World::State::fade() {
  std::size_t moving = 0;
  std::optional<std::vector<std::uint64_t>> bearing;  // computed when first needed
  for (const auto& body : bodies) moving += body->is_loose() && body->fading < 0;
  std::vector<std::pair<double, Body*>> loose;  // volume and body, to choose those beyond the limit
  for (const auto& body : bodies) {
    if (body->kind != Body::Kind::kGroup || body->held || body->members.size() != 1 || body->gone) continue;
    Object& owner = *objects[body->object];
    const double volume = owner.fragments->set.fragments[body->members[0]].volume;
    if (body->fading >= 0) {
      body->fading += settings.step;
      if (body->fading >= settings.fade_time) {
        owner.body_of[body->members[0]] = nullptr;
        ledger.brought -= energy(*body);
        wake_around(*body, true);
        remove(*body);
        ++faded;
      }
      continue;
    }
    body->asleep = body->rigid->isActive() ? 0 : body->asleep + settings.step;
    bool fades =
        body->asleep > settings.fade_after && volume < settings.debris_share * owner.fragments->volume;
    if (fades) {  // unless it supports something, which would fall
      if (!bearing) bearing = bearers();
      fades = !std::binary_search(bearing->begin(), bearing->end(), body->number);
    }
    if (fades)
      body->fading = 0;
    else if (moving > settings.max_bodies)
      loose.emplace_back(volume, body.get());
  }
  if (moving > settings.max_bodies) {
    std::stable_sort(loose.begin(), loose.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t k = 0; k < std::min(loose.size(), moving - settings.max_bodies); ++k)
      loose[k].second->fading = 0;
  }
  std::size_t balls = 0;
  for (const auto& body : bodies) balls += body->kind == Body::Kind::kBall && !body->gone;
  for (const auto& body : bodies)
    if (balls > settings.max_balls && body->kind == Body::Kind::kBall && !body->gone) {
      ledger.brought -= energy(*body);
      wake_around(*body, true);
      remove(*body);
      --balls;
    }
  sweep_out();
}

}  // namespace fracture::world
