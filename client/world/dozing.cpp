// Lets single pieces of a heap sleep while others move.
//
// Bullet lets touching bodies sleep only together, so one creeping shard keeps hundreds awake, for seconds.
// Here, a piece that has hardly moved for a moment, relative to its size, dozes: it does not move, and Bullet
// treats it as part of the ground. So contacts among dozing pieces cost nothing, and the moving pieces form
// small islands. (Sleep of single bodies follows Schmidl and Milenkovic, "A Fast Impulsive Contact Suite for
// Rigid Body Simulation", 2004; the rules are ours.) A dozing piece wakes in three cases:
//
// 1. Something is about to hit it. As many of its neighbours as the blow can move wake, too.
// 2. Something that it touched when it fell asleep has moved away. So nothing hangs in the air.
// 3. Something that it touched has broken or faded, even if it was held, or a blast pushes the piece.
//
// Dozing adds no energy, because the piece is at rest when it wakes. Only hits break its bonds, because the
// load on it rests on the ground. A few pieces are not worth it and sleep by Bullet's rules.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "client/world/state.hpp"

namespace fracture::world {
namespace {

constexpr std::size_t kFewPieces = 40;  ///< a heap has more pieces than this
/// Fraction of the radius. A piece that moves less than this within kMoment is at rest. A shard of 10 cm may
/// creep by 2 cm per second; a falling one moves that far in a thirtieth of a second.
constexpr double kHardly = 0.05, kMoment = 0.3;  // seconds
/// Times as long for a piece whose centre is not above its contacts, because it starts to fall slowly.
constexpr double kTilted = 4;
/// Fraction of the radius by which neighbours may move away. It is more than they may creep before they doze
/// themselves.
constexpr double kGone = 0.1;
constexpr double kWakingSpeed = 0.3;  ///< m/s of approach, as for all hits
/// m/s: a blow wakes as many pieces as it could give this speed together. Others would not visibly move.
constexpr double kFelt = 0.5;
/// Minimum upward component of a contact's normal at which one body supports the other.
constexpr double kBears = 0.3;
constexpr double kInTouch = 0.002;  ///< metres: contacts at most this far apart after the step count

/// Whether the body can never be removed from under a piece.
bool stays(const Body& body) { return body.kind == Body::Kind::kGround || body.kind == Body::Kind::kStatic; }

/// Upper bound in metres on how far its farthest point has moved.
double moved(const Body& body, const btTransform& from) {
  const btTransform& now = body.rigid->getWorldTransform();
  double turned = 0;
  for (int row = 0; row < 3; ++row) turned += (now.getBasis()[row] - from.getBasis()[row]).length2();
  return (now.getOrigin() - from.getOrigin()).length() + body.radius * std::sqrt(turned);
}

/// Speed in m/s at which a body approaches what it meets within the step.
double approach_of(const Body& body, const btPersistentManifold& manifold, double step) {
  double fastest = 0;
  for (int k = 0; k < manifold.getNumContacts(); ++k) {
    const btManifoldPoint& point = manifold.getContactPoint(k);
    const btVector3 arm = point.getPositionWorldOnB() - body.rigid->getCenterOfMassPosition();
    const double along = body.rigid->getVelocityInLocalPoint(arm).dot(point.m_normalWorldOnB);
    const double speed = manifold.getBody0() == body.rigid.get() ? -along : along;
    if (point.getDistance() < kInTouch + step * speed) fastest = std::max(fastest, speed);
  }
  return fastest;
}

}  // namespace

/// Bodies are sorted by number.
Body* World::State::numbered(std::uint64_t number) const {
  const auto at =
      std::lower_bound(bodies.begin(), bodies.end(), number,
                       [](const auto& body, std::uint64_t wanted) { return body->number < wanted; });
  return at != bodies.end() && (*at)->number == number ? at->get() : nullptr;
}

void World::State::lay(Body& body) const {
  body.dozes = true;
  body.moments = body.rigid->getLocalInertia();
  set_motion(body, glm::dvec3(0), glm::dvec3(0));
  body.rigid->setInterpolationWorldTransform(body.rigid->getWorldTransform());
  body.rigid->clearForces();
  body.rigid->setMassProps(0, btVector3(0, 0, 0));
  body.rigid->updateInertiaTensor();
  body.rigid->forceActivationState(ISLAND_SLEEPING);
}

void World::State::wake(Body& body) const {
  if (!body.dozes) return;
  body.dozes = false;
  body.touched.clear();
  body.rigid->setMassProps(body.mass.mass, body.moments);
  body.rigid->updateInertiaTensor();
  body.rigid->forceActivationState(ACTIVE_TAG);
  body.rigid->setDeactivationTime(0);
  body.still = body.quiet = body.asleep = 0;
  body.watched = -1;
}

const Body* bearer(const btPersistentManifold& manifold) {
  if (manifold.getNumContacts() == 0) return nullptr;
  const double up = manifold.getContactPoint(0).m_normalWorldOnB.y();  // from the second to the first
  if (std::fabs(up) < kBears) return nullptr;
  return static_cast<const Body*>((up > 0 ? manifold.getBody1() : manifold.getBody0())->getUserPointer());
}

/// Also wakes bodies that sleep by Bullet's rules, because Bullet wakes nothing when a body is removed. (A
/// crumb that fades next to a heap need not wake it.)
void World::State::wake_around(const Body& gone, bool only_borne) {
  for (const auto& body : bodies)
    if (std::any_of(body->touched.begin(), body->touched.end(), [&](const Body::Touched& other) {
          return other.number == gone.number && (other.bears || !only_borne);
        }))
      wake(*body);
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
    const auto *first = manifold.getBody0(), *second = manifold.getBody1();
    if (manifold.getNumContacts() == 0 || (first != gone.rigid.get() && second != gone.rigid.get())) continue;
    Body& other = *static_cast<Body*>((first == gone.rigid.get() ? second : first)->getUserPointer());
    if (!other.moves() || other.rigid->isActive()) continue;
    if (only_borne && bearer(manifold) != &gone) continue;
    other.rigid->activate(true);
    other.still = other.quiet = other.asleep = 0;
  }
}

/// Wakes neighbour after neighbour, until the blow could move no more mass.
void World::State::wake_by(Body& struck, double momentum) const {
  std::vector<Body*> reached{&struck};
  double mass = 0;
  for (std::size_t k = 0; k < reached.size() && kFelt * mass <= momentum; ++k) {
    Body& body = *reached[k];
    if (!body.dozes) continue;
    mass += body.mass.mass;
    for (const Body::Touched& other : body.touched)
      if (Body* next = numbered(other.number); next != nullptr && next->dozes) reached.push_back(next);
    wake(body);
  }
}

void World::State::rouse() const {
  for (const auto& body : bodies) {
    const bool lost =
        std::any_of(body->touched.begin(), body->touched.end(), [&](const Body::Touched& other) {
          const Body* now = numbered(other.number);  // null: it is gone, which has already woken this one
          return now != nullptr && now->moves() && moved(*now, other.then) > kGone * body->radius;
        });
    if (lost) wake(*body);
  }
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    // Bullet gives its own list only to callers that may change it.
    const btPersistentManifold& manifold =
        *const_cast<PairDispatcher&>(dispatcher).getManifoldByIndexInternal(m);
    auto &first = *static_cast<Body*>(manifold.getBody0()->getUserPointer()),
         &second = *static_cast<Body*>(manifold.getBody1()->getUserPointer());
    if (first.dozes == second.dozes) continue;
    Body &lying = first.dozes ? first : second, &other = first.dozes ? second : first;
    if (!other.moves() || !other.rigid->isActive()) continue;
    const double approach = approach_of(other, manifold, settings.step),
                 momentum = other.mass.mass * approach;
    if (approach > kWakingSpeed && momentum > kFelt * lying.mass.mass) wake_by(lying, momentum);
  }
}

void World::State::doze() {
  std::size_t pieces = 0;
  for (const auto& body : bodies)
    pieces += body->kind == Body::Kind::kGroup && (body->dozes || (body->moves() && body->rigid->isActive()));
  std::vector<Body*> tired;
  for (const auto& body : bodies) {
    if (body->kind != Body::Kind::kGroup || !body->moves() || !body->rigid->isActive()) continue;
    if (body->watched < 0 || moved(*body, body->watched_from) > kHardly * body->radius) {
      body->watched_from = body->rigid->getWorldTransform();
      body->watched = 0;
      continue;
    }
    body->watched += settings.step;
    const double enough = body->tips.value_or(false) ? kTilted * kMoment : kMoment;
    if (pieces > kFewPieces && body->watched >= enough && !body->leans_on.empty())
      tired.push_back(body.get());
  }
  if (tired.empty()) return;
  for (Body* body : tired) lay(*body);
  for (const Touch& touch : touches)
    if (touch.pressed && !stays(*touch.a) && !stays(*touch.b))
      for (const auto& [body, other, up] :
           {std::tuple(touch.a, touch.b, touch.normal.y), std::tuple(touch.b, touch.a, -touch.normal.y)})
        if (std::binary_search(tired.begin(), tired.end(), body,
                               [](const Body* a, const Body* b) { return a->number < b->number; }))
          body->touched.push_back({other->number, other->rigid->getWorldTransform(), up > kBears});
}

}  // namespace fracture::world
