// Limits what a solver that converges only roughly may add, and decides when a heap rests.
#include <algorithm>
#include <cmath>
#include <vector>

#include "client/world/state.hpp"

namespace fracture::world {
namespace {

/// Moving bodies that touch, directly or through other moving bodies.
struct Island {
  bool grounded = false;  ///< touches a fixed body, which takes momentum and gives no energy
  double mass = 0, kinetic = 0;
  double gained = 0;  ///< J, in this step
  double lifted = 0;  ///< J: of all bodies that rose
  glm::dvec3 momentum{0};
  double swiftest = 0;  ///< m²/s²: twice the largest kinetic energy per kilogram of any body before the step
  glm::dvec3 taken{0};   ///< total momentum taken from bodies that got too fast …
  double free_mass = 0;  ///< … and mass of the other bodies, which share it
};

std::size_t root_of(std::vector<std::size_t>& parent, std::size_t k) {
  while (parent[k] != k) k = parent[k] = parent[parent[k]];
  return k;
}

/// Height of the lowest point of a convex shape in this pose.
double lowest(const btConvexShape& shape, const btTransform& place) {
  const btVector3 down = place.getBasis().transpose() * btVector3(0, -1, 0);
  return (place * shape.localGetSupportVertexWithoutMarginNonVirtual(down)).y() - shape.getMarginNonVirtual();
}

/// Whether all contacts lie on one side of a line through its centre, seen from above: it then tilts over
/// them.
bool topples(const Body& body, std::vector<double>& angles) {
  angles.clear();
  for (const glm::dvec2& arm : body.leans_on) angles.push_back(std::atan2(arm.y, arm.x));
  if (angles.empty()) return true;
  std::sort(angles.begin(), angles.end());
  constexpr double kPi = 3.14159265358979323846;
  double widest = angles.front() + 2 * kPi - angles.back();
  for (std::size_t k = 1; k < angles.size(); ++k) widest = std::max(widest, angles[k] - angles[k - 1]);
  return widest > kPi;
}

constexpr double kDeepest = 0.002;  ///< metres below the ground

glm::dvec3 velocity_of(const Body& body) { return from_bullet(body.rigid->getLinearVelocity()); }
glm::dvec3 spin_of(const Body& body) { return from_bullet(body.rigid->getAngularVelocity()); }

}  // namespace

double lowest(const Body& body) {
  const btTransform& place = body.rigid->getWorldTransform();
  const btCollisionShape& shape = *body.rigid->getCollisionShape();
  double least = place.getOrigin().y();
  if (!shape.isCompound()) return std::min(least, lowest(static_cast<const btConvexShape&>(shape), place));
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  for (int k = 0; k < compound.getNumChildShapes(); ++k)
    least = std::min(least, lowest(static_cast<const btConvexShape&>(*compound.getChildShape(k)),
                                   place * compound.getChildTransform(k)));
  return least;
}

/// The solver weighs contacts against one another, so a shard under a heavy block may be pressed through the
/// floor and come back late. A body deeper than two millimetres is raised at once. The things on it must give
/// way, and the energy for lifting is taken from the motion (limit_gains).
void World::State::keep_above_ground() {
  for (const auto& body : bodies) {
    if (!body->moves() || !body->rigid->isActive()) continue;
    btTransform place = body->rigid->getWorldTransform();
    btVector3 low, high;
    body->rigid->getAabb(low, high);
    if (std::min(low.y(), place.getOrigin().y()) > -kDeepest) continue;
    const double depth = -lowest(*body);
    if (!(depth > kDeepest)) continue;
    place.getOrigin().setY(place.getOrigin().y() + depth - kDeepest);
    body->rigid->setWorldTransform(place);
    body->rigid->setInterpolationWorldTransform(place);
  }
}

/// Lowers the body by up to `by` J/kg, as far as the ground allows.
void World::State::lower(Body& body, double by) const {
  const double g = glm::length(settings.gravity), way = std::min(by / g, lowest(body) + kDeepest);
  if (!(way > 0)) return;
  btTransform place = body.rigid->getWorldTransform();
  place.setOrigin(place.getOrigin() + to_bullet(way / g * settings.gravity));
  body.rigid->setWorldTransform(place);
  body.rigid->setInterpolationWorldTransform(place);
}

/// Enforces two laws, which Bullet's contacts sometimes break, for each island of touching bodies:
///
/// 1. After the step, no body has more kinetic energy per kilogram than the fastest had before it, plus the
/// energy of its own fall. Otherwise a chain from heavy to ever lighter pieces would pass on speed like a
/// whip; real pieces crumble there. In a flying island, momentum taken from one piece goes to the others, so
/// the total is conserved.
///
/// 2. The island as a whole gains no energy, kinetic and potential. Corrections of overlaps lift bodies, and
/// impulses between unequal masses miss their target. The excess is taken from the motion; in flight, only
/// from the motion relative to the common centre. If that is too little (a heavy block is lifted off
/// something wedged under it), part of the lift is undone and the overlap remains.
///
/// A body's limit depends on its own island, not on the whole world, and a resting island gains no allowance.
/// So the limit does not creep upwards from step to step.
void World::State::limit_gains() {
  std::vector<std::size_t> parent(bodies.size());
  for (std::size_t k = 0; k < bodies.size(); ++k) bodies[k]->island = parent[k] = k;
  for (const Touch& touch : touches)
    if (touch.a->moves() && touch.b->moves()) {
      const std::size_t a = root_of(parent, touch.a->island), b = root_of(parent, touch.b->island);
      parent[std::max(a, b)] = std::min(a, b);
    }
  std::vector<Island> islands(bodies.size());
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    Body& body = *bodies[k];
    body.island = root_of(parent, k);
    if (!body.moves()) continue;
    Island& island = islands[body.island];
    island.swiftest = std::max(island.swiftest, 2 * body.kinetic_before / body.mass.mass);
  }
  for (const Touch& touch : touches)
    if (touch.a->moves() != touch.b->moves())
      islands[(touch.a->moves() ? touch.a : touch.b)->island].grounded = true;

  const double least = std::pow(settings.step * glm::length(settings.gravity), 2);
  constexpr int kRounds = 4;  // momentum passed on may make another body too fast
  std::vector<char> limited(bodies.size(), 0);
  for (int round = 0; round < kRounds; ++round) {
    bool any = false;
    for (Island& island : islands) {
      island.taken = glm::dvec3(0);
      island.free_mass = 0;
    }
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      Body& body = *bodies[k];
      if (!body.moves()) continue;
      Island& island = islands[body.island];
      const double fall = std::max(0.0, body.height_before - height(body)),
                   limit = std::max(least, island.swiftest + 2 * fall),
                   swift = 2 * kinetic_energy(body) / body.mass.mass;
      if (swift > limit && body.kind != Body::Kind::kBall) {
        const double kept = std::sqrt(limit / swift);
        const glm::dvec3 velocity = velocity_of(body);
        island.taken += body.mass.mass * (1 - kept) * velocity;
        set_motion(body, kept * velocity, kept * spin_of(body));
        limited[k] = any = true;
      }
      if (!limited[k]) island.free_mass += body.mass.mass;
    }
    if (!any) break;
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      Body& body = *bodies[k];
      if (!body.moves() || limited[k]) continue;
      const Island& island = islands[body.island];
      if (!island.grounded && island.taken != glm::dvec3(0))
        set_motion(body, velocity_of(body) + island.taken / island.free_mass, spin_of(body));
    }
  }

  for (const auto& body : bodies) {
    if (!body->moves()) continue;
    Island& island = islands[body->island];
    const double kinetic = kinetic_energy(*body);
    island.mass += body->mass.mass;
    island.kinetic += kinetic;
    island.momentum += body->mass.mass * velocity_of(*body);
    const double rise = height(*body) - body->height_before;
    island.gained += kinetic - body->kinetic_before + body->mass.mass * rise;
    island.lifted += body->mass.mass * std::max(rise, 0.0);
  }
  for (const auto& body : bodies) {
    if (!body->moves()) continue;
    const Island& island = islands[body->island];
    if (!(island.gained > 0)) continue;
    const glm::dvec3 common = island.grounded ? glm::dvec3(0) : island.momentum / island.mass;
    const double inner = std::max(0.0, island.kinetic - 0.5 * island.mass * glm::dot(common, common));
    const double kept = island.gained < inner ? std::sqrt(1 - island.gained / inner) : 0;
    set_motion(*body, common + kept * (velocity_of(*body) - common), kept * spin_of(*body));
    const double rise = height(*body) - body->height_before,
                 owed = std::min(island.gained - inner, island.lifted);
    if (island.grounded && owed > 0 && rise > 0) lower(*body, rise * owed / island.lifted);
  }
}

/// The solver never quite settles a heap of slivers: each step pushes some with the error of the last. Motion
/// slower than one and a half steps of gravity is only such error, so it is damped. One twitching shard must
/// not keep the heap awake, so sleep depends on the mean speed over about twenty steps, and on the mean of
/// the heap. A body whose centre is not above its contacts also starts slowly, but it is falling, so it is
/// not damped.
void World::State::calm() {
  const double slow = 1.5 * settings.step * glm::length(settings.gravity);
  constexpr double kSlowSpin = 1.5, kLeft = 0.8;  // rad/s; fraction of the speed left after a step
  std::vector<double> room;
  for (const Touch& touch : touches)
    for (Body* body : {touch.a, touch.b}) {
      if (!touch.pressed || !body->moves() || !body->rigid->isActive()) continue;
      const glm::dvec3 velocity = from_bullet(body->rigid->getLinearVelocity()),
                       spin = from_bullet(body->rigid->getAngularVelocity());
      if (!(glm::length(velocity) < slow) || !(glm::length(spin) < kSlowSpin)) continue;
      if (!body->tips) body->tips = topples(*body, room);
      if (!*body->tips) set_motion(*body, kLeft * velocity, kLeft * spin);
    }
  constexpr double kWeight = 0.05;  // weight of one step in the moving mean
  // still_speed (m/s): slower bodies count as still. The longer ago the last break was, the more certainly
  // such motion comes only from the solver's work on wedged pieces. So the limit grows with time.
  constexpr double kPatience = 3, kMostPatience = 6;  // seconds; maximum factor
  const double since = settings.step * static_cast<double>(steps - ledger.last_swap);
  const double waited = since / kPatience,
               still_speed = 0.08 * std::clamp(waited * waited, 1.0, kMostPatience);
  // Metres: bodies pressed deeper into others must come out first. Wedged bodies never do, so the wait is
  // limited.
  constexpr double kSunk = 0.004, kLongestWait = 1;  // seconds
  // Per Bullet island (bodies that touch, directly or through others), which sleeps only as a whole.
  struct Island {
    double mass = 0, motion = 0, fastest = 0, sunk = 0;
    bool quiet(double speed) const { return motion < 0.5 * speed * mass && fastest < 5 * speed; }
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
    body->quiet = island != nullptr && island->quiet(still_speed) ? body->quiet + settings.step : 0;
    const bool still = body->lively < still_speed ||
                       (body->quiet > 0 && (island->sunk < kSunk || body->quiet > kLongestWait));
    body->still = still ? body->still + settings.step : 0;
    body->rigid->setDeactivationTime(body->still);
  }
}

}  // namespace fracture::world
