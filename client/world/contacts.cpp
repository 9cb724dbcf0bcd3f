// Applies the solver's contact impulses to objects.
#include <algorithm>
#include <cmath>

#include "client/world/state.hpp"

namespace fracture::world {
namespace {

/// Impulse of a manifold's point on its first body, in the world, along the normal and the two friction
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

/// The cause of a hit of `other` on `body`. The faster of the two counts as the hitting body.
Cause cause_of(const Body& body, const Body& other, const glm::dvec3& where) {
  if (other.kind == Body::Kind::kBall) return Cause::kBall;
  const bool piece = other.kind == Body::Kind::kGroup &&
                     glm::length(velocity_before(other, where)) > glm::length(velocity_before(body, where));
  return piece ? Cause::kPiece : Cause::kFall;
}

/// A new contact between bodies that approached each other is a hit, whose impulse comes within the contact
/// time. Other contacts carry weight.
constexpr int kFreshSteps = 2;
constexpr double kHitSpeed = 0.3;       ///< m/s
constexpr std::uint64_t kParting = 30;  ///< steps: see `parting`

}  // namespace

void World::State::hit_whole(const Hit& hit) {
  const auto known =
      std::find_if(hits.begin(), hits.end(), [&](const Hit& other) { return other.body == hit.body; });
  if (known == hits.end()) {
    hits.push_back(hit);
    return;
  }
  known->impulse += hit.impulse;
  known->lost += hit.lost;
  known->approach = std::max(known->approach, hit.approach);
  if (hit.strongest > known->strongest) {
    known->strongest = hit.strongest;
    known->cause = hit.cause;
    known->point = hit.point;
  }
}

void World::State::collect_contacts() {
  touches.clear();
  knocked = false;
  const auto knocks = [](const Body& a, const Body& b) {
    return (a.kind == Body::Kind::kBall || a.kind == Body::Kind::kWhole) && a.moves() &&
           b.kind == Body::Kind::kGroup;
  };
  hits.clear();
  for (const auto& body : bodies) {
    body->forces.clear();
    body->total_force = body->sunk = 0;
    body->leans_on.clear();
    body->tips.reset();
  }
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
    auto* first = static_cast<Body*>(manifold.getBody0()->getUserPointer());
    auto* second = static_cast<Body*>(manifold.getBody1()->getUserPointer());
    if (first == nullptr || second == nullptr || first->gone || second->gone) continue;
    // Bullet keeps old impulses between two sleeping bodies.
    if (!first->rigid->isActive() && !second->rigid->isActive()) continue;
    // A piece that has just come loose gets stuck in the hole that it leaves, where real edges would crumble.
    // It loads no bonds until it is out. Otherwise, every hit would crack a wall from end to end.
    const bool parting = first->kind == Body::Kind::kGroup && second->kind == Body::Kind::kGroup &&
                         first->object == second->object &&
                         steps - std::max(first->born, second->born) < kParting;
    bool overlaps = false, pressed = false;
    glm::dvec3 meet(0), normal(0);
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      overlaps = overlaps || point.getDistance() <= 0;
      meet = from_bullet(point.getPositionWorldOnB());
      normal = from_bullet(point.m_normalWorldOnB);
      if (!(point.m_appliedImpulse > 0)) continue;
      pressed = true;
      first->sunk = std::max(first->sunk, -point.getDistance());
      second->sunk = std::max(second->sunk, -point.getDistance());
      const glm::dvec3 where = from_bullet(point.getPositionWorldOnB());
      for (Body* body : {first, second})
        if (body->moves()) {
          const glm::dvec3 arm = where - from_bullet(body->rigid->getCenterOfMassPosition());
          body->leans_on.emplace_back(arm.x, arm.z);
        }
      const glm::dvec3 impulse = impulse_on_first(point);
      const double approach =
          std::max(0.0, -glm::dot(velocity_before(*first, where) - velocity_before(*second, where),
                                  from_bullet(point.m_normalWorldOnB)));
      const bool is_hit = point.getLifeTime() <= kFreshSteps && approach > kHitSpeed;
      const double strength = glm::length(impulse),
                   lost = 0.5 * strength * approach * (1 - point.m_combinedRestitution);
      for (const bool of_first : {true, false}) {
        Body& body = of_first ? *first : *second;
        const glm::dvec3 on_body = of_first ? impulse : -impulse;
        const Cause cause = cause_of(body, of_first ? *second : *first, where);
        const Hit hit{&body, where, on_body, strength, approach, lost, cause};
        if (body.kind == Body::Kind::kWhole && is_hit) hit_whole(hit);
        if (body.kind != Body::Kind::kGroup || parting || (body.dozes && !is_hit)) continue;
        if (body.members.size() == 1) {
          if (is_hit) hit_whole(hit);
          continue;
        }
        const int child = of_first ? point.m_index0 : point.m_index1;
        if (child < 0 || static_cast<std::size_t>(child) >= body.fragment_of_child.size()) continue;
        const Pose pose = body.asset_to_world();
        const double time = is_hit ? settings.contact_time : settings.step;
        const glm::dvec3 force = glm::conjugate(pose.rotation) * on_body / time;
        body.forces.push_back({body.fragment_of_child[static_cast<std::size_t>(child)], force,
                               pose.local(where), is_hit, cause});
        body.total_force += glm::length(force);
      }
    }
    if (!pressed && !overlaps) continue;
    touches.push_back({first, second, pressed, meet, normal});
    knocked = knocked || knocks(*first, *second) || knocks(*second, *first);
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
      if (!object.hit()) {
        object.hit_at = steps;
        object.hit_by = hit.cause;
      }
      hit.body->stored_before = object.stored;
      object.stored = std::max(object.stored, (hit.body->held ? 1 : settings.burst) * hit.lost);
      object.impacts.push_back(impact);
      if (object.asked) continue;
      object.asked = true;
      events.push_back({Event::Kind::kBreak, hit.body->object, 0, impact, hit.point});
      ask_for_neighbours(*hit.body, impulse, hit.approach);
    } else if (!hit.body->held && !hit.body->asked && hit.body->fading < 0 && live <= settings.live_bodies) {
      const std::uint32_t fragment = hit.body->members[0];
      const Fragment& f = object.fragments->set.fragments[fragment];
      if (f.volume < settings.secondary_share * object.fragments->volume ||
          impulse <= 1.5 * object.critical_speed * f.mass.mass)
        continue;
      hit.body->asked = true;
      events.push_back({Event::Kind::kBreakFragment, hit.body->object, fragment, impact, hit.point});
    }
  }
}

/// Gives the body its motion from before the step, as if it had met nothing. Its height did change, and it
/// gets no energy for that, because the same blow may be undone in several steps while a crack runs through a
/// wall.
void World::State::restore(Body& body) const {
  const double g = glm::length(settings.gravity), rose = height(body) - body.height_before;
  glm::dvec3 velocity = body.velocity_before;
  double kept = 1;
  if (g > 0) {
    const glm::dvec3 up = -settings.gravity / g;
    const double rise = glm::dot(velocity, up), square = rise * rise - 2 * rose;
    velocity += ((rise > 0 ? 1 : -1) * std::sqrt(std::max(square, 0.0)) - rise) * up;
    if (square < 0) {  // an overlap lifted it higher than its own speed could
      const double rest = body.kinetic_before - 0.5 * body.mass.mass * rise * rise;
      kept = std::sqrt(std::max(0.0, 1 + 0.5 * body.mass.mass * square / std::max(rest, 1e-12)));
    }
  }
  velocity *= kept;
  set_motion(body, velocity, kept * body.spin_before);
  // The body has turned since, and about another of its axes the same spin may have more energy.
  const double most = body.kinetic_before - body.mass.mass * rose,
               straight = 0.5 * body.mass.mass * glm::dot(velocity, velocity), all = kinetic_energy(body);
  if (all > std::max(most, straight))
    set_motion(body, velocity,
               kept * std::sqrt(std::max(most - straight, 0.0) / (all - straight)) * body.spin_before);
}

void World::State::split_overloaded() {
  std::vector<Body*> overloaded;
  for (const auto& body : bodies) {
    if (body->kind != Body::Kind::kGroup || body->bonds.empty() || body->gone) continue;
    if (!(body->total_force > 1.05 * body->borne)) continue;
    Object& object = *objects[body->object];
    if (object.guarded) {
      glm::dvec3 struck(0);
      for (const PointForce& f : body->forces)
        if (f.hit) struck += settings.contact_time * f.force;
      if (glm::length(struck) <= object.spec.strength) continue;
      object.guarded = false;
    }
    const glm::dvec3 gravity = glm::conjugate(body->asset_to_world().rotation) * settings.gravity;
    if (break_bonds(object, body->members, body->bonds, body->forces, gravity) > 0) {
      overloaded.push_back(body.get());
      if (object.sound) {
        const auto hardest = std::max_element(
            body->forces.begin(), body->forces.end(), [](const PointForce& a, const PointForce& b) {
              return glm::dot(a.force, a.force) < glm::dot(b.force, b.force);
            });
        breaks.push_back({steps, body->object, hardest->cause, 0});
        object.sound = false;
      }
    } else {
      body->borne = body->total_force;
    }
  }
  // The impulses were computed for unbroken groups, so they are wrong (see world.hpp). Bodies that touch,
  // even through others, share their momentum, so all of them are reset together.
  for (Body* body : overloaded) body->restore = true;
  for (bool spread = !overloaded.empty(); spread;) {
    spread = false;
    for (const Touch& touch : touches) {
      if (!touch.pressed || touch.a->restore == touch.b->restore) continue;
      Body& through = touch.a->restore ? *touch.a : *touch.b;
      // The ground and held bodies pass nothing on, unless they are the bodies that broke.
      if (!through.moves() && std::find(overloaded.begin(), overloaded.end(), &through) == overloaded.end())
        continue;
      touch.a->restore = touch.b->restore = spread = true;
    }
  }
  // A blow that is undone has not cost any energy yet.
  for (const Touch& touch : touches)
    if (touch.a->restore || touch.b->restore)
      for (const Body* body : {touch.a, touch.b})
        if (body->kind == Body::Kind::kWhole && body->stored_before >= 0)
          objects[body->object]->stored = body->stored_before;
  for (const auto& body : bodies) {
    body->stored_before = -1;
    if (!body->restore) continue;
    body->restore = false;
    if (!body->moves() || body->gone) continue;
    restore(*body);
  }
  for (Body* body : overloaded) split(*body);
  sweep_out();
}

}  // namespace fracture::world
