// What the solver's contact impulses do to objects.
#include <algorithm>

#include "client/world/state.hpp"

namespace fracture::world {
namespace {

/// Impulse of a manifold's point on its first body, in the world: along the normal and the two friction
/// directions. The normal points from the second body to the first.
glm::dvec3 impulse_on_first(const btManifoldPoint& p) {
  return from_bullet(p.m_appliedImpulse * p.m_normalWorldOnB +
                     p.m_appliedImpulseLateral1 * p.m_lateralFrictionDir1 +
                     p.m_appliedImpulseLateral2 * p.m_lateralFrictionDir2);
}

glm::dvec3 velocity_before(const Body& body, const glm::dvec3& point) {
  if (!body.moves()) return glm::dvec3(0);
  return body.velocity_before +
         glm::cross(body.spin_before, point - from_bullet(body.rigid->getCenterOfMassPosition()));
}

/// A young contact of bodies that came at one another is a hit, whose impulse comes within the contact time.
/// Others carry weight.
constexpr int kFreshSteps = 2;
constexpr double kHitSpeed = 0.3;       ///< m/s
constexpr std::uint64_t kParting = 30;  ///< steps

}  // namespace

void World::State::hit_whole(Body& body, const glm::dvec3& point, const glm::dvec3& impulse,
                             double approach) {
  const auto known =
      std::find_if(hits.begin(), hits.end(), [&](const Hit& hit) { return hit.body == &body; });
  const double size = glm::length(impulse);
  if (known == hits.end()) {
    hits.push_back({&body, point, impulse, size, approach});
    return;
  }
  known->impulse += impulse;
  known->approach = std::max(known->approach, approach);
  if (size > known->strongest) {
    known->strongest = size;
    known->point = point;
  }
}

void World::State::collect_contacts() {
  touches.clear();
  hits.clear();
  for (const auto& body : bodies) {
    body->forces.clear();
    body->total_force = body->sunk = 0;
  }
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
    auto* first = static_cast<Body*>(manifold.getBody0()->getUserPointer());
    auto* second = static_cast<Body*>(manifold.getBody1()->getUserPointer());
    if (first == nullptr || second == nullptr || first->gone || second->gone) continue;
    // What has just come off wedges itself fast in the hole that it leaves; real edges crumble there. It
    // loads no bonds before it is out, else every hit would run through a wall from end to end.
    const bool parting = first->kind == Body::Kind::kGroup && second->kind == Body::Kind::kGroup &&
                         first->object == second->object &&
                         steps - std::max(first->born, second->born) < kParting;
    bool touched = false;
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      if (!(point.m_appliedImpulse > 0)) continue;
      touched = true;
      first->sunk = std::max(first->sunk, -point.getDistance());
      second->sunk = std::max(second->sunk, -point.getDistance());
      const glm::dvec3 where = from_bullet(point.getPositionWorldOnB());
      const glm::dvec3 impulse = impulse_on_first(point);
      const double approach =
          std::max(0.0, -glm::dot(velocity_before(*first, where) - velocity_before(*second, where),
                                  from_bullet(point.m_normalWorldOnB)));
      const bool is_hit = point.getLifeTime() <= kFreshSteps && approach > kHitSpeed;
      for (const bool of_first : {true, false}) {
        Body& body = of_first ? *first : *second;
        const glm::dvec3 on_body = of_first ? impulse : -impulse;
        if (body.kind == Body::Kind::kWhole && is_hit) hit_whole(body, where, on_body, approach);
        if (body.kind != Body::Kind::kGroup || parting) continue;
        if (body.members.size() == 1) {
          if (is_hit) hit_whole(body, where, on_body, approach);
          continue;
        }
        const int child = of_first ? point.m_index0 : point.m_index1;
        if (child < 0 || static_cast<std::size_t>(child) >= body.fragment_of_child.size()) continue;
        const Pose pose = body.asset_to_world();
        const double time = is_hit ? settings.contact_time : settings.step;
        const glm::dvec3 force = glm::conjugate(pose.rotation) * on_body / time;
        body.forces.push_back(
            {body.fragment_of_child[static_cast<std::size_t>(child)], force, pose.local(where), is_hit});
        body.total_force += glm::length(force);
      }
    }
    if (touched) touches.push_back({first, second});
  }
}

void World::State::raise_impacts() {
  for (const Hit& hit : hits) {
    Object& object = *objects[hit.body->object];
    const double impulse = glm::length(hit.impulse);
    if (!(impulse > 0)) continue;
    const Pose pose = hit.body->asset_to_world();
    const Impact impact{pose.local(hit.point), glm::conjugate(pose.rotation) * (hit.impulse / impulse),
                        impulse, 0.5 * impulse * hit.approach};
    if (hit.body->kind == Body::Kind::kWhole) {
      if (impulse <= object.spec.strength) continue;
      object.impacts.push_back(impact);
      if (object.asked) continue;
      object.asked = true;
      events.push_back({Event::Kind::kBreak, hit.body->object, 0, impact});
    } else if (!hit.body->held && !hit.body->asked && hit.body->fading < 0) {
      const std::uint32_t fragment = hit.body->members[0];
      const Fragment& f = object.fragments->set.fragments[fragment];
      if (f.volume < settings.secondary_share * object.fragments->volume ||
          impulse <= 1.5 * object.critical_speed * f.mass.mass)
        continue;
      hit.body->asked = true;
      events.push_back({Event::Kind::kBreakFragment, hit.body->object, fragment, impact});
    }
  }
}

void World::State::split_overloaded() {
  std::vector<Body*> overloaded;
  for (const auto& body : bodies) {
    if (body->kind != Body::Kind::kGroup || body->bonds.empty() || body->gone) continue;
    if (!(body->total_force > 1.05 * body->borne)) continue;
    Object& object = *objects[body->object];
    const glm::dvec3 gravity = glm::conjugate(body->asset_to_world().rotation) * settings.gravity;
    if (break_bonds(object, body->members, body->bonds, body->forces, gravity) > 0)
      overloaded.push_back(body.get());
    else
      body->borne = body->total_force;
  }
  // The impulses were those of bodies that do not exist: see world.hpp. All that touch, also by way of a
  // third, share their momentum, and go back together.
  for (Body* body : overloaded) body->restore = true;
  for (bool spread = !overloaded.empty(); spread;) {
    spread = false;
    for (const Touch& touch : touches) {
      if (touch.a->restore == touch.b->restore) continue;
      Body& through = touch.a->restore ? *touch.a : *touch.b;
      // The ground and what is held pass nothing on, except where they are what came apart.
      if (!through.moves() && std::find(overloaded.begin(), overloaded.end(), &through) == overloaded.end())
        continue;
      touch.a->restore = touch.b->restore = spread = true;
    }
  }
  for (const auto& body : bodies) {
    if (!body->restore) continue;
    body->restore = false;
    if (!body->moves() || body->gone) continue;
    set_motion(*body, body->velocity_before + settings.step * settings.gravity, body->spin_before);
  }
  for (Body* body : overloaded) split(*body);
  sweep_out();
}

/// Contacts of heavy pieces with light ones with lighter ones would hand on speed as a whip does. Real pieces
/// crumble there: no fragment gets faster than the fastest body was before the step, nor spins so fast that
/// it would fling parts away at more than half of that.
void World::State::limit_speeds() {
  double limit = 0;
  for (const auto& body : bodies)
    if (body->moves()) limit = std::max(limit, glm::length(body->velocity_before));
  limit += settings.step * glm::length(settings.gravity);
  for (const auto& body : bodies) {
    if (body->kind != Body::Kind::kGroup || !body->moves()) continue;
    const glm::dvec3 velocity = from_bullet(body->rigid->getLinearVelocity()),
                     spin = from_bullet(body->rigid->getAngularVelocity());
    const double speed = glm::length(velocity), edge = 2 * body->radius * glm::length(spin);
    if (speed > limit || edge > limit)
      set_motion(*body, std::min(1.0, limit / std::max(speed, 1e-9)) * velocity,
                 std::min(1.0, limit / std::max(edge, 1e-9)) * spin);
  }
}

/// The solver never quite settles a heap of slivers: each step pushes some by what the last left over. Below
/// the speed that gravity gives within a step and a half such motion is only that. And one shard that
/// twitches must not keep the heap awake: sleep goes by the mean over some twenty steps, and by that of the
/// heap.
void World::State::calm() {
  const double slow = 1.5 * settings.step * glm::length(settings.gravity);
  constexpr double kSlowSpin = 1.5, kLeft = 0.8;  // rad/s; of the speed after a step
  for (const Touch& touch : touches)
    for (Body* body : {touch.a, touch.b}) {
      if (!body->moves() || !body->rigid->isActive()) continue;
      const glm::dvec3 velocity = from_bullet(body->rigid->getLinearVelocity()),
                       spin = from_bullet(body->rigid->getAngularVelocity());
      if (glm::length(velocity) < slow && glm::length(spin) < kSlowSpin)
        set_motion(*body, kLeft * velocity, kLeft * spin);
    }
  constexpr double kWeight = 0.05, kStill = 0.08;  // of a step in the mean; m/s
  constexpr double kSunk = 0.004;  // metres: what is squeezed so far in, has to come out first
  // By Bullet's island (bodies that touch, also by way of others), which sleeps as a whole or not at all.
  struct Island {
    double mass = 0, motion = 0, fastest = 0, sunk = 0;
    bool still() const { return motion < 0.5 * kStill * mass && fastest < 5 * kStill && sunk < kSunk; }
  };
  std::vector<Island> islands(static_cast<std::size_t>(bullet.getNumCollisionObjects()));
  const auto island_of = [&](const Body& body) -> Island* {
    const int tag = body.rigid->getIslandTag();
    return tag >= 0 && static_cast<std::size_t>(tag) < islands.size()
               ? &islands[static_cast<std::size_t>(tag)]
               : nullptr;
  };
  for (const auto& body : bodies) {
    if (!body->moves() || !body->rigid->isActive()) continue;
    const double speed =
        body->rigid->getLinearVelocity().length() + body->radius * body->rigid->getAngularVelocity().length();
    body->lively += kWeight * (speed - body->lively);
    if (Island* island = island_of(*body)) {
      island->mass += body->mass.mass;
      island->motion += body->mass.mass * body->lively;
      island->fastest = std::max(island->fastest, body->lively);
      island->sunk = std::max(island->sunk, body->sunk);
    }
  }
  for (const auto& body : bodies) {
    if (!body->moves() || !body->rigid->isActive()) continue;
    const Island* island = island_of(*body);
    const bool still = body->lively < kStill || (island != nullptr && island->still());
    body->still = still ? body->still + settings.step : 0;
    body->rigid->setDeactivationTime(body->still);
  }
}

void World::State::look_ahead() {
  if (!(settings.foresight > 0)) return;
  constexpr std::uint64_t kEvery = 4;  // steps
  constexpr double kYouth = 5;         // seconds: later it rolls
  constexpr int kPieces = 5;           // of the parabola
  struct Sweep : btCollisionWorld::ClosestConvexResultCallback {
    using ClosestConvexResultCallback::ClosestConvexResultCallback;
    const btCollisionObject* self = nullptr;
    bool needsCollision(btBroadphaseProxy* proxy) const override {
      return proxy->m_clientObject != self && ClosestConvexResultCallback::needsCollision(proxy);
    }
  };
  for (const auto& ball : bodies) {
    if (ball->kind != Body::Kind::kBall || (steps - ball->born) % kEvery != 0 || !ball->rigid->isActive() ||
        static_cast<double>(steps - ball->born) * settings.step > kYouth)
      continue;
    const glm::dvec3 from = from_bullet(ball->rigid->getWorldTransform().getOrigin()),
                     velocity = from_bullet(ball->rigid->getLinearVelocity());
    btSphereShape sphere(0.9 * ball->radius);
    const auto at = [&](double t) { return from + t * velocity + 0.5 * t * t * settings.gravity; };
    for (int k = 0; k < kPieces; ++k) {
      const double t0 = settings.foresight * k / kPieces, t1 = settings.foresight * (k + 1) / kPieces;
      const btVector3 start = to_bullet(at(t0)), end = to_bullet(at(t1));
      Sweep sweep(start, end);
      sweep.self = ball->rigid.get();
      bullet.convexSweepTest(&sphere, btTransform(btQuaternion::getIdentity(), start),
                             btTransform(btQuaternion::getIdentity(), end), sweep);
      if (!sweep.hasHit()) continue;
      const auto* hit = static_cast<const Body*>(sweep.m_hitCollisionObject->getUserPointer());
      if (hit == nullptr || hit->kind != Body::Kind::kWhole) break;
      Object& object = *objects[hit->object];
      if (object.asked || object.ahead) break;
      const glm::dvec3 speed = velocity + t0 * settings.gravity, normal = from_bullet(sweep.m_hitNormalWorld);
      const double approach = std::max(0.0, -glm::dot(speed, normal));
      const double inverse_mass = 1 / ball->mass.mass + (hit->held ? 0 : 1 / hit->mass.mass);
      const double impulse = approach / inverse_mass;
      if (impulse <= object.spec.strength) break;
      object.ahead = true;
      const Pose pose = hit->asset_to_world();
      events.push_back({Event::Kind::kAhead,
                        hit->object,
                        0,
                        {pose.local(from_bullet(sweep.m_hitPointWorld)),
                         glm::conjugate(pose.rotation) * -normal, impulse, 0.5 * impulse * approach}});
      break;
    }
  }
}

}  // namespace fracture::world
