// What will be hit soon: its fragments are asked for ahead, and are there at the contact.
#include <algorithm>
#include <optional>

#include "client/world/state.hpp"

namespace fracture::world {
namespace {

constexpr std::uint64_t kEvery = 4;  ///< steps
constexpr double kYouth = 5;         ///< seconds: a ball that is older rolls
constexpr int kPieces = 5;           ///< of the parabola

struct Sweep : btCollisionWorld::ClosestConvexResultCallback {
  using ClosestConvexResultCallback::ClosestConvexResultCallback;
  const btCollisionObject* self = nullptr;
  bool needsCollision(btBroadphaseProxy* proxy) const override {
    return proxy->m_clientObject != self && ClosestConvexResultCallback::needsCollision(proxy);
  }
};

/// A body that meets nothing until then.
struct Flight {
  glm::dvec3 from, velocity, spin, gravity;
  glm::dquat rotation;

  Pose at(double t) const {
    const double angle = t * glm::length(spin);
    const glm::dquat turn = angle > 0 ? glm::angleAxis(angle, glm::normalize(spin)) : glm::dquat(1, 0, 0, 0);
    return {from + t * velocity + 0.5 * t * t * gravity, glm::normalize(turn * rotation)};
  }
};

struct Meeting {
  double time;  ///< s from now
  Pose pose;    ///< of the moving body then
  const Body* other;
  glm::dvec3 point, normal;  ///< in the world; the normal points to the moving body
};

/// What a convex shape of a body in flight meets first within `ahead` seconds. `place`: the shape in its body.
std::optional<Meeting> first_meeting(const btDiscreteDynamicsWorld& bullet, const btRigidBody& self,
                                     const btConvexShape& shape, const Pose& place, const Flight& flight,
                                     double ahead) {
  for (int k = 0; k < kPieces; ++k) {
    const double t0 = ahead * k / kPieces, t1 = ahead * (k + 1) / kPieces;
    const btTransform start = to_bullet(flight.at(t0) * place), end = to_bullet(flight.at(t1) * place);
    Sweep sweep(start.getOrigin(), end.getOrigin());
    sweep.self = &self;
    bullet.convexSweepTest(&shape, start, end, sweep);
    if (!sweep.hasHit()) continue;
    const auto* other = static_cast<const Body*>(sweep.m_hitCollisionObject->getUserPointer());
    if (other == nullptr) return std::nullopt;
    const double time = t0 + sweep.m_closestHitFraction * (t1 - t0);
    return Meeting{time, flight.at(time), other, from_bullet(sweep.m_hitPointWorld),
                   glm::normalize(from_bullet(sweep.m_hitNormalWorld))};
  }
  return std::nullopt;
}

/// 1/kg: how much speed at a point an impulse along the normal gives a body there (Mirtich, "Impulse-based
/// Dynamic Simulation of Rigid Body Systems", 1996).
double mobility(const Body& body, const Pose& pose, const glm::dvec3& point, const glm::dvec3& normal) {
  if (!body.moves()) return 0;
  const btVector3 inertia = body.rigid->getLocalInertia();
  const glm::dvec3 arm = glm::conjugate(pose.rotation) * glm::cross(point - pose.position, normal);
  return 1 / body.mass.mass + arm.x * arm.x / inertia.x() + arm.y * arm.y / inertia.y() +
         arm.z * arm.z / inertia.z();
}

}  // namespace

void World::State::ask_ahead(ObjectId id, const Pose& asset_to_world, const glm::dvec3& point,
                             const glm::dvec3& push, double impulse, double approach) {
  Object& object = *objects[id];
  if (object.whole == nullptr || object.asked || object.ahead || impulse <= object.spec.strength) return;
  object.ahead = true;
  events.push_back({Event::Kind::kAhead,
                    id,
                    0,
                    {asset_to_world.local(point), glm::conjugate(asset_to_world.rotation) * push, impulse,
                     0.5 * impulse * approach},
                    point});
}

void World::State::look_ahead() {
  if (!(settings.foresight > 0)) return;
  std::vector<const Body*> supported;
  for (const Touch& touch : touches)
    if (touch.pressed)
      for (const Body* body : {touch.a, touch.b})
        if (body->kind == Body::Kind::kWhole) supported.push_back(body);
  for (const auto& body : bodies) {
    const bool ball = body->kind == Body::Kind::kBall;
    if ((!ball && body->kind != Body::Kind::kWhole) || !body->moves() || !body->rigid->isActive()) continue;
    if ((steps - body->born) % kEvery != 0) continue;
    const glm::dvec3 velocity = from_bullet(body->rigid->getLinearVelocity());
    if (ball) {
      if (static_cast<double>(steps - body->born) * settings.step > kYouth) continue;
    } else {
      const Object& object = *objects[body->object];
      const double most = glm::length(velocity) + settings.foresight * glm::length(settings.gravity);
      if (object.asked || object.ahead || body->mass.mass * most <= object.spec.strength ||
          std::find(supported.begin(), supported.end(), body.get()) != supported.end())
        continue;
    }
    const Pose pose = body->body_pose();
    const glm::dvec3 spin = from_bullet(body->rigid->getAngularVelocity());
    const Flight flight{pose.position, velocity, ball ? glm::dvec3(0) : spin, settings.gravity,
                        pose.rotation};
    std::optional<Meeting> first;
    const auto look = [&](const btConvexShape& shape, const Pose& place) {
      const double ahead = first ? first->time : settings.foresight;
      if (!(ahead > 0)) return;
      if (auto meeting = first_meeting(bullet, *body->rigid, shape, place, flight, ahead))
        if (!first || meeting->time < first->time) first = meeting;
    };
    if (ball) {
      look(btSphereShape(0.9 * body->radius), {});
    } else if (const btCollisionShape* shape = body->rigid->getCollisionShape(); shape->isCompound()) {
      const auto& compound = static_cast<const btCompoundShape&>(*shape);
      for (int k = 0; k < compound.getNumChildShapes(); ++k)
        look(static_cast<const btConvexShape&>(*compound.getChildShape(k)),
             from_bullet(compound.getChildTransform(k)));
    } else {
      look(static_cast<const btConvexShape&>(*shape), {});
    }
    if (!first) continue;
    const Body& other = *first->other;
    const Pose there = other.body_pose();
    const auto speed_of = [&](const Body& b, const Pose& at, const glm::dvec3& v) {
      return v + (b.moves()
                      ? glm::cross(from_bullet(b.rigid->getAngularVelocity()), first->point - at.position)
                      : glm::dvec3(0));
    };
    const glm::dvec3 mine = speed_of(*body, first->pose, velocity + first->time * settings.gravity),
                     its = speed_of(other, there, from_bullet(other.rigid->getLinearVelocity()));
    const double approach = std::max(0.0, -glm::dot(mine - its, first->normal));
    const double impulse = approach / (mobility(*body, first->pose, first->point, first->normal) +
                                       mobility(other, there, first->point, first->normal));
    if (!ball)
      ask_ahead(body->object, first->pose * inverse(body->local), first->point, first->normal, impulse,
                approach);
    if (other.kind == Body::Kind::kWhole)
      ask_ahead(other.object, other.asset_to_world(), first->point, -first->normal, impulse, approach);
  }
}

}  // namespace fracture::world
