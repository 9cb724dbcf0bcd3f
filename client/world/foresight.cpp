// Predicts hits, so that fragments are requested ahead and are ready at the contact.
#include <algorithm>
#include <cmath>
#include <optional>

#include "client/world/state.hpp"

namespace fracture::world {
namespace {

constexpr std::uint64_t kEvery = 4;  ///< steps
constexpr double kYouth = 5;         ///< seconds: older balls roll
constexpr int kPieces = 5;           ///< segments of the parabola
constexpr int kBehind = 3;           ///< further things that a ball may meet after the first one
constexpr double kTopples = 0.3;     ///< m/s: a body moving faster on its support may fall over
/// Fraction of the strength. A predicted contact this hard lets fragments replace the whole, because a face
/// lands with several contacts.
constexpr double kLikely = 0.5;
constexpr double kInTime =
    0.1;  ///< seconds: an answer takes half of it, and a later one would find pieces already loose
constexpr std::uint64_t kSoon = 6;  ///< steps: within this time, the path is checked once more

struct Sweep : btCollisionWorld::ClosestConvexResultCallback {
  using ClosestConvexResultCallback::ClosestConvexResultCallback;
  std::span<const btCollisionObject* const> but;
  bool needsCollision(btBroadphaseProxy* proxy) const override {
    return std::find(but.begin(), but.end(), proxy->m_clientObject) == but.end() &&
           ClosestConvexResultCallback::needsCollision(proxy);
  }
};

/// The motion of a body in free flight.
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
  double time;  ///< seconds from now
  Pose pose;    ///< of the moving body at that time
  const Body* other;
  glm::dvec3 point, normal;  ///< in the world; the normal points to the moving body
};

/// The first meeting of a convex shape of a body in flight within the given seconds. `but`: bodies that it
/// flies through. `place`: the shape's pose in its body.
std::optional<Meeting> first_meeting(const btDiscreteDynamicsWorld& bullet,
                                     std::span<const btCollisionObject* const> but,
                                     const btConvexShape& shape, const Pose& place, const Flight& flight,
                                     double from, double to) {
  for (int k = 0; k < kPieces; ++k) {
    const double t0 = from + (to - from) * k / kPieces, t1 = from + (to - from) * (k + 1) / kPieces;
    const btTransform start = to_bullet(flight.at(t0) * place), end = to_bullet(flight.at(t1) * place);
    Sweep sweep(start.getOrigin(), end.getOrigin());
    sweep.but = but;
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

/// 1/kg: the speed at a point that an impulse along the normal gives a body there (Mirtich, "Impulse-based
/// Dynamic Simulation of Rigid Body Systems", 1996).
double mobility(const Body& body, const Pose& pose, const glm::dvec3& point, const glm::dvec3& normal) {
  if (!body.moves()) return 0;
  const btVector3 inertia = body.rigid->getLocalInertia();
  const glm::dvec3 arm = glm::conjugate(pose.rotation) * glm::cross(point - pose.position, normal);
  return 1 / body.mass.mass + arm.x * arm.x / inertia.x() + arm.y * arm.y / inertia.y() +
         arm.z * arm.z / inertia.z();
}

}  // namespace

void World::State::ask_ahead(ObjectId id, const Pose& asset_to_world, const Foreseen& hit) {
  Object& object = *objects[id];
  if (object.whole == nullptr || object.asked || hit.most <= object.spec.strength) return;
  if (hit.time && hit.impulse > kLikely * object.spec.strength)
    object.awaited = steps + static_cast<std::uint64_t>(*hit.time / settings.step);
  if (object.ahead) return;
  object.ahead = true;
  events.push_back({Event::Kind::kAhead,
                    id,
                    0,
                    {asset_to_world.local(hit.point), glm::conjugate(asset_to_world.rotation) * hit.push,
                     hit.impulse, 0.5 * hit.impulse * hit.approach},
                    hit.point});
  ask_for_neighbours(*object.whole, hit.impulse, hit.approach);
}

/// Objects that touch a hit object receive at most the impulse that it received.
void World::State::ask_for_neighbours(const Body& body, double impulse, double approach) {
  if (!(settings.foresight > 0)) return;
  for (const Touch& touch : touches) {
    if (touch.a != &body && touch.b != &body) continue;
    const Body& other = touch.a == &body ? *touch.b : *touch.a;
    if (other.kind == Body::Kind::kWhole)
      ask_ahead(
          other.object, other.asset_to_world(),
          {touch.point, touch.a == &body ? -touch.normal : touch.normal, impulse, impulse, approach, {}});
  }
}

/// A body tilting on its support falls by at most its radius, and half its mass acts on the edge that lands.
/// This is a guess: the request is sent once, and the answer waits unused if nothing happens.
void World::State::ask_for_toppling(const Body& body, const Touch& support) {
  const double speed = glm::length(from_bullet(body.rigid->getLinearVelocity())) +
                       body.radius * glm::length(from_bullet(body.rigid->getAngularVelocity()));
  if (speed < kTopples) return;
  const double landing = speed + std::sqrt(glm::length(settings.gravity) * body.radius);
  const double impulse = 0.5 * body.mass.mass * landing;
  ask_ahead(
      body.object, body.asset_to_world(),
      {support.point, support.a == &body ? support.normal : -support.normal, impulse, impulse, landing, {}});
}

/// Requests finer fragments for bonded fragments at rest. This must happen before the hit, because hit
/// fragments separate. Only fragments near the hit become finer, so balls that hit elsewhere still find
/// coarse ones.
void World::State::ask_again(const Body& ball, const Body& other, const Foreseen& hit) {
  if (other.kind != Body::Kind::kGroup || other.bonds.empty() || !(*hit.time > kInTime)) return;
  const Object& object = *objects[other.object];
  if (other.moves() && glm::length(from_bullet(other.rigid->getLinearVelocity())) +
                               other.radius * glm::length(from_bullet(other.rigid->getAngularVelocity())) >
                           kTopples)
    return;
  const double strength = other.held ? object.spec.strength : object.critical_speed * other.mass.mass;
  if (hit.impulse <= strength) return;
  const Pose pose = other.asset_to_world();
  events.push_back({Event::Kind::kAgain,
                    other.object,
                    other.members.front(),
                    {pose.local(hit.point), glm::conjugate(pose.rotation) * hit.push, hit.impulse,
                     0.5 * hit.impulse * hit.approach},
                    hit.point,
                    ball.ball});
}

bool World::expects_hit(ObjectId id) const {
  const Object& object = *state_->objects.at(id);
  if (object.whole == nullptr) return false;
  const std::uint64_t now = state_->steps;
  return object.asked ||
         (object.awaited && now + kSoon >= *object.awaited && now <= *object.awaited + 2 * kEvery);
}

/// Whether the ball is too slow to break anything in the world; a ball that lies on something does not get
/// faster. This saves time, because a ball may roll in a heap for seconds among dozens of pieces.
bool World::State::is_harmless(const Body& ball) const {
  const auto speed_of = [](const Body& body) {
    return body.moves() ? glm::length(from_bullet(body.rigid->getLinearVelocity())) +
                              body.radius * glm::length(from_bullet(body.rigid->getAngularVelocity()))
                        : 0;
  };
  const bool lies = std::any_of(touches.begin(), touches.end(), [&](const Touch& touch) {
    return touch.pressed && (touch.a == &ball || touch.b == &ball);
  });
  const double fastest = speed_of(ball) + (lies ? 0 : settings.foresight * glm::length(settings.gravity));
  return std::none_of(bodies.begin(), bodies.end(), [&](const auto& body) {
    const Object* object =
        body->kind == Body::Kind::kWhole || !body->bonds.empty() ? objects[body->object].get() : nullptr;
    if (object == nullptr) return false;
    const double bears = body->kind == Body::Kind::kWhole || body->held
                             ? object->spec.strength
                             : object->critical_speed * body->mass.mass;
    return ball.mass.mass * (fastest + speed_of(*body)) > bears;
  });
}

void World::State::look_ahead() {
  if (!(settings.foresight > 0)) return;
  for (const auto& body : bodies) {
    const bool ball = body->kind == Body::Kind::kBall;
    if ((!ball && body->kind != Body::Kind::kWhole) || !body->moves() || !body->rigid->isActive()) continue;
    if ((steps - body->born) % kEvery != 0) continue;
    const glm::dvec3 velocity = from_bullet(body->rigid->getLinearVelocity());
    if (ball) {
      if (static_cast<double>(steps - body->born) * settings.step > kYouth) continue;
      if (is_harmless(*body)) continue;
    } else {
      const Object& object = *objects[body->object];
      if (object.asked) continue;
      const auto support = std::find_if(touches.begin(), touches.end(), [&](const Touch& touch) {
        return touch.pressed && (touch.a == body.get() || touch.b == body.get());
      });
      if (support != touches.end()) {
        ask_for_toppling(*body, *support);
        continue;
      }
      const double most = glm::length(velocity) + settings.foresight * glm::length(settings.gravity);
      if (body->mass.mass * most <= object.spec.strength) continue;
    }
    const Pose pose = body->body_pose();
    const glm::dvec3 spin = from_bullet(body->rigid->getAngularVelocity());
    const Flight flight{pose.position, velocity, ball ? glm::dvec3(0) : spin, settings.gravity,
                        pose.rotation};
    std::vector<const btCollisionObject*> but{body->rigid.get()};
    const auto next_meeting = [&](double from) {
      std::optional<Meeting> first;
      const auto look = [&](const btConvexShape& shape, const Pose& place) {
        const double to = first ? first->time : settings.foresight;
        if (!(to > from)) return;
        if (auto meeting = first_meeting(bullet, but, shape, place, flight, from, to))
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
      return first;
    };
    std::optional<Meeting> met = next_meeting(0);
    for (int behind = 0; met; ++behind) {
      const Body& other = *met->other;
      const Pose there = other.body_pose();
      const auto speed_of = [&](const Body& b, const Pose& at, const glm::dvec3& v) {
        return v + (b.moves()
                        ? glm::cross(from_bullet(b.rigid->getAngularVelocity()), met->point - at.position)
                        : glm::dvec3(0));
      };
      const glm::dvec3 mine = speed_of(*body, met->pose, velocity + met->time * settings.gravity),
                       its = speed_of(other, there, from_bullet(other.rigid->getLinearVelocity()));
      const double approach = std::max(0.0, -glm::dot(mine - its, met->normal));
      const double impulse = approach / (mobility(*body, met->pose, met->point, met->normal) +
                                         mobility(other, there, met->point, met->normal));
      // Upper bound: the impulse if neither body turned. Several simultaneous contacts come close to it.
      const double free_mobility =
          (body->moves() ? 1 / body->mass.mass : 0) + (other.moves() ? 1 / other.mass.mass : 0);
      Foreseen hit{met->point, met->normal, impulse, approach / free_mobility, approach, {}};
      // A thing behind another is hit more weakly, later, or not at all, so its time is not known.
      if (behind == 0) hit.time = met->time;
      if (!ball) ask_ahead(body->object, met->pose * inverse(body->local), hit);
      hit.push = -hit.push;
      if (other.kind == Body::Kind::kWhole) ask_ahead(other.object, other.asset_to_world(), hit);
      if (ball && behind == 0) ask_again(*body, other, hit);
      const bool through = other.kind == Body::Kind::kWhole || other.kind == Body::Kind::kGroup;
      if (!ball || !through || behind == kBehind) break;
      but.push_back(other.rigid.get());
      met = next_meeting(met->time);
    }
  }
}

}  // namespace fracture::world
