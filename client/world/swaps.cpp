// Replaces bodies by others: when an answer arrives, and when bonds break.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "client/world/state.hpp"

namespace fracture::world {
namespace {

constexpr int kRounds = 4;  ///< of loading and breaking within one step; further rounds follow in later steps

std::vector<Motion> motions(std::span<Body* const> bodies) {
  std::vector<Motion> result;
  for (const Body* body : bodies)
    if (body->moves()) result.push_back(body->motion());
  return result;
}

void set_motions(std::span<Body* const> bodies, std::span<const Motion> wanted) {
  std::size_t k = 0;
  for (Body* body : bodies)
    if (body->moves()) {
      set_motion(*body, wanted[k].velocity, wanted[k].spin);
      ++k;
    }
}

/// The same angular momentum, about another point.
glm::dvec3 about(const Momentum& momentum, const glm::dvec3& center) {
  return momentum.angular + glm::cross(momentum.center - center, momentum.linear);
}

std::size_t broken_bonds(const Object& object) {
  std::size_t count = 0;
  for (std::size_t k = 0; k < object.bond_load.size(); ++k)
    count += object.bond_load[k] < 0 && !object.fragments->set.bonds[k].gone;
  return count;
}

std::uint32_t nearest(const FragmentSet& set, std::span<const std::uint32_t> members,
                      const glm::dvec3& point) {
  std::uint32_t best = members.front();
  double least = HUGE_VAL;
  for (const std::uint32_t m : members)
    for (const Hull& hull : set.fragments[m].hulls)
      for (const glm::dvec3& p : hull) {
        const double d = glm::dot(p - point, p - point);
        if (d < least) {
          least = d;
          best = m;
        }
      }
  return best;
}

}  // namespace

std::size_t World::State::break_bonds(Object& object, std::span<const std::uint32_t> members,
                                      std::vector<std::uint32_t>& bonds, std::span<const PointForce> forces,
                                      const glm::dvec3& gravity) {
  const FragmentSet& set = object.fragments->set;
  std::vector<std::uint32_t> part_of(set.fragments.size());
  std::size_t broken = 0;
  const std::vector<std::uint32_t> before_all = bonds;
  for (int round = 0; round < kRounds; ++round) {
    const auto parts = components(members, bonds, set);
    for (std::uint32_t p = 0; p < parts.size(); ++p)
      for (const std::uint32_t m : parts[p]) part_of[m] = p;
    std::vector<std::vector<std::uint32_t>> bonds_of(parts.size());
    for (const std::uint32_t bond : bonds) bonds_of[part_of[set.bonds[bond].a]].push_back(bond);
    const std::size_t before = broken;
    std::vector<std::uint32_t> kept;
    for (std::uint32_t p = 0; p < parts.size(); ++p) {
      LoadCase load{
          .members = parts[p], .bonds = bonds_of[p], .reach = object.spec.reach, .gravity = gravity};
      std::vector<MassProperties> masses;
      bool loaded = false;
      for (const std::uint32_t m : parts[p]) {
        masses.push_back(set.fragments[m].mass);
        loaded = loaded || set.fragments[m].anchored;
      }
      const glm::dvec3 center = combine(masses).center;
      for (const PointForce& f : forces) {
        if (part_of[f.fragment] != p) continue;
        const auto at = std::lower_bound(parts[p].begin(), parts[p].end(), f.fragment) - parts[p].begin();
        Forces& kind = f.hit ? load.hits : load.lasting;
        kind.on_member.resize(parts[p].size(), glm::dvec3(0));
        kind.on_member[static_cast<std::size_t>(at)] += f.force;
        kind.torque += glm::cross(f.point - center, f.force);
        loaded = true;
      }
      if (!loaded || bonds_of[p].empty()) {
        kept.insert(kept.end(), bonds_of[p].begin(), bonds_of[p].end());
        continue;
      }
      const std::vector<double> loads = bond_loads(set, load);
      const double front =
          std::max(1.0, object.spec.crack_front * *std::max_element(loads.begin(), loads.end()));
      for (std::size_t k = 0; k < loads.size(); ++k) {
        const std::uint32_t bond = bonds_of[p][k];
        if (loads[k] > front) {
          object.bond_load[bond] = -1;
          ++broken;
        } else {
          object.bond_load[bond] = static_cast<float>(loads[k]);
          kept.push_back(bond);
        }
      }
    }
    std::sort(kept.begin(), kept.end());
    bonds = std::move(kept);
    if (broken == before) break;
  }
  return broken > 0 ? broken - hold_together(object, members, before_all, bonds) : 0;
}

std::vector<Body*> World::State::spawn(ObjectId object, std::span<const std::uint32_t> members,
                                       std::span<const std::uint32_t> bonds, const Pose& asset_to_world,
                                       const Motion& field) {
  const FragmentSet& set = objects[object]->fragments->set;
  const auto parts = components(members, bonds, set);
  std::vector<std::uint32_t> part_of(set.fragments.size());
  for (std::uint32_t p = 0; p < parts.size(); ++p)
    for (const std::uint32_t m : parts[p]) part_of[m] = p;
  std::vector<std::vector<std::uint32_t>> bonds_of(parts.size());
  for (const std::uint32_t bond : bonds) bonds_of[part_of[set.bonds[bond].a]].push_back(bond);
  std::vector<Body*> made;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    Body& body = add_group(object, parts[p], bonds_of[p], asset_to_world);
    made.push_back(&body);
    if (!body.moves()) continue;
    const glm::dvec3 center = asset_to_world.point(body.mass.center);
    set_motion(body, field.velocity + glm::cross(field.spin, center - field.mass.center), field.spin);
    body.rigid->activate(true);
  }
  return made;
}

/// Gives the new bodies the old ones' momentum, and records both.
void World::State::replace(std::span<Body* const> old, std::span<Body* const> by, Swap swap) {
  swap.step = steps;
  for (const Body* body : old) swap.held = swap.held || body->held;
  for (const Body* body : by) swap.held = swap.held || body->held;
  swap.groups = by.size();
  for (const Body* body : by) swap.fragments += body->members.size();
  swap.before = momentum(motions(old));
  if (!swap.held && swap.before.mass > 0) {
    std::vector<Motion> now = motions(by);
    set_momentum(now, swap.before.linear, about(swap.before, momentum(now).center));
    set_motions(by, now);
  }
  // The pieces' total mass may differ from the whole's, for example if the mesh is open. The ledger must not
  // count the difference in potential energy as a gain.
  for (const Body* body : old) ledger.brought -= body->mass.mass * height(*body);
  for (const Body* body : by) ledger.brought += body->mass.mass * height(*body);
  ledger.last_swap = steps;
  for (const Body* body : old)
    if (std::find(by.begin(), by.end(), body) == by.end()) wake_around(*body);
  swap.after = momentum(motions(by));
  swap.after.angular = about(swap.after, swap.before.center);
  if (!(swap.before.mass > 0)) swap.after.angular = glm::dvec3(0);
  swaps.push_back(swap);
}

void World::State::burst(std::span<Body* const> pieces, const glm::dvec3& point, double energy,
                         double fastest) {
  if (pieces.size() < 2 || !(energy > 0)) return;
  std::vector<Motion> now = motions(pieces);
  const Momentum before = momentum(now);
  if (!(before.mass > 0)) return;
  std::vector<Motion> thrown = now;
  for (Motion& body : thrown) {
    const glm::dvec3 away = body.mass.center - point;
    const double distance = glm::length(away);
    if (distance > 1e-9) body.velocity += away / distance;  // 1 m/s for all; scaled below
  }
  set_momentum(thrown, before.linear, before.angular);
  double unit = 0, most = 0;
  for (std::size_t k = 0; k < now.size(); ++k) {
    const glm::dvec3 dv = thrown[k].velocity - now[k].velocity;
    unit += 0.5 * now[k].mass.mass * glm::dot(dv, dv);
    most = std::max(most, glm::length(dv));
  }
  if (!(unit > 0)) return;
  const double scale = std::min(std::sqrt(energy / unit), fastest / most);
  for (std::size_t k = 0; k < now.size(); ++k) {
    now[k].velocity += scale * (thrown[k].velocity - now[k].velocity);
    now[k].spin += scale * (thrown[k].spin - now[k].spin);
  }
  set_momentum(now, before.linear, before.angular);
  set_motions(pieces, now);
}

void World::State::split(Body& body) {
  Object& object = *objects[body.object];
  Swap swap{.object = body.object};
  swap.broken_bonds = broken_bonds(object);
  const Pose pose = body.asset_to_world();
  const Motion field = body.moves() ? body.motion() : Motion{};
  const std::vector<std::uint32_t> members = body.members, bonds = body.bonds;
  Body* const old[] = {&body};
  // A crack that separates nothing keeps the body, because a new one would have to find all contacts again.
  if (components(members, bonds, object.fragments->set).size() == 1) {
    body.borne = 0;
    return replace(old, old, swap);
  }
  std::vector<Body*> made = spawn(body.object, members, bonds, pose, field);
  replace(old, made, swap);
  remove(body);
}

void World::fracture(ObjectId id, std::shared_ptr<const PreparedFragments> fragments) {
  State& s = *state_;
  Object& object = *s.objects.at(id);
  if (object.whole == nullptr || fragments == nullptr || fragments->parts.empty()) return;
  Body& whole = *object.whole;
  const Pose pose = whole.asset_to_world();
  const Motion field = whole.moves() ? whole.motion() : Motion{};
  object.fragments = std::move(fragments);
  const FragmentSet& set = object.fragments->set;
  object.body_of.assign(set.fragments.size(), nullptr);
  object.bond_load.assign(set.bonds.size(), 0);
  std::vector<std::uint32_t> members(set.fragments.size()), bonds(set.bonds.size());
  for (std::uint32_t k = 0; k < members.size(); ++k) members[k] = k;
  for (std::uint32_t k = 0; k < bonds.size(); ++k) bonds[k] = k;
  std::vector<PointForce> forces;
  for (const Impact& impact : object.impacts)
    forces.push_back({nearest(set, members, impact.point),
                      impact.impulse / s.settings.contact_time * impact.direction, impact.point, true});
  for (const Blast& blast : object.blasts) {
    const std::vector<PointForce> all = s.forces_of(blast, set, members);
    forces.insert(forces.end(), all.begin(), all.end());
  }
  Swap swap{.object = id};
  object.sound = !object.hit();
  object.guarded = object.sound && object.ahead;
  if (!object.sound) s.breaks.push_back({s.steps, id, object.hit_by, s.steps - object.hit_at});
  swap.broken_bonds =
      s.break_bonds(object, members, bonds, forces, glm::conjugate(pose.rotation) * s.settings.gravity);
  std::vector<Body*> made = s.spawn(id, members, bonds, pose, field);
  Body* const old[] = {&whole};
  s.replace(old, made, swap);
  if (!object.impacts.empty()) {
    const Impact& first = object.impacts.front();
    const double approach = first.impulse > 0 ? 2 * first.energy / first.impulse : 0;
    if (!whole.held) {
      s.burst(made, pose.point(first.point), object.stored, 0.5 * approach);
    } else if (Body* hit = object.body_of[forces.front().fragment]; hit->moves()) {
      // A held object passed the impulse to the ground. The loose piece gets it, limited by the hit's speed.
      const double speed =
          std::min({first.impulse / hit->mass.mass, approach, std::sqrt(2 * object.stored / hit->mass.mass)});
      set_motion(*hit, speed * (pose.rotation * first.direction), glm::dvec3(0));
    }
  }
  for (const Blast& blast : object.blasts)
    for (Body* body : made) s.push(*body, {pose.point(blast.point), blast.impulse, blast.radius});
  object.impacts.clear();
  object.blasts.clear();
  object.stored = 0;
  s.remove(whole);
  object.whole = nullptr;
  s.sweep_out();
}

bool World::change(ObjectId id, std::shared_ptr<const PreparedFragments> changed) {
  State& s = *state_;
  Object& object = *s.objects.at(id);
  if (!changed || !object.fragments || changed->before.lock() != object.fragments) return false;
  Body* body = nullptr;
  for (const std::uint32_t k : changed->replaced) {
    Body* const holder = object.body_of[k];
    if (holder == nullptr || (body != nullptr && holder != body)) return false;
    body = holder;
  }
  if (body == nullptr || body->fading >= 0) return false;
  const std::shared_ptr<const PreparedFragments> was = std::exchange(object.fragments, std::move(changed));
  const PreparedFragments& now = *object.fragments;
  std::vector<bool> broken;
  for (const float load : object.bond_load) broken.push_back(load < 0);

  std::vector<std::uint32_t> members, bonds;
  std::set_difference(body->members.begin(), body->members.end(), now.replaced.begin(), now.replaced.end(),
                      std::back_inserter(members));
  members.insert(members.end(), now.made.begin(), now.made.end());
  std::sort(members.begin(), members.end());
  for (const std::uint32_t bond : body->bonds)
    if (!now.set.bonds[bond].gone) bonds.push_back(bond);
  object.body_of.resize(now.set.fragments.size(), nullptr);
  object.bond_load.resize(now.set.bonds.size(), 0);
  object.cracked.resize(now.set.bonds.size(), false);
  const auto is_member = [&](std::uint32_t k) {
    return std::binary_search(members.begin(), members.end(), k);
  };
  for (std::size_t k = 0; k < now.set.bonds.size(); ++k) {
    const Bond& bond = now.set.bonds[k];
    if (k >= now.first_bond && is_member(bond.a) && is_member(bond.b) &&
        !is_cracked(now, was->set, k, broken)) {
      bonds.push_back(static_cast<std::uint32_t>(k));
    } else if (k >= now.first_bond || bond.gone) {
      object.bond_load[k] = -1;
      object.cracked[k] = true;  // broken before, so no crack is witnessed now
    }
  }
  const Pose pose = body->asset_to_world();
  const Motion field = body->moves() ? body->motion() : Motion{};
  for (const std::uint32_t k : now.replaced) object.body_of[k] = nullptr;
  const std::vector<Body*> made = s.spawn(id, members, bonds, pose, field);
  for (Body* part : made) {
    part->born = body->born;
    part->borne = body->borne;
  }
  Body* const old[] = {body};
  s.replace(old, made, {.object = id, .broken_bonds = broken_bonds(object)});
  s.remove(*body);
  s.sweep_out();
  return true;
}

std::size_t World::bonded_within(ObjectId id, std::uint32_t fragment, const glm::dvec3& point,
                                 double radius) const {
  const Object& object = *state_->objects.at(id);
  const Body* body = fragment < object.body_of.size() ? object.body_of[fragment] : nullptr;
  if (body == nullptr) return 0;
  return static_cast<std::size_t>(
      std::count_if(body->members.begin(), body->members.end(), [&](std::uint32_t k) {
        return glm::distance(object.fragments->set.fragments[k].mass.center, point) <= radius;
      }));
}

std::optional<ObjectId> World::fracture_fragment(ObjectId id, std::uint32_t fragment,
                                                 std::shared_ptr<const PreparedFragments> pieces) {
  State& s = *state_;
  if (!pieces || pieces->parts.empty()) return std::nullopt;
  {
    const Object& parent = *s.objects.at(id);
    if (fragment >= parent.body_of.size() || parent.body_of[fragment] == nullptr ||
        parent.body_of[fragment]->members.size() != 1)
      return std::nullopt;
  }
  const auto made_id = static_cast<ObjectId>(s.objects.size());
  s.objects.push_back(std::make_unique<Object>());
  Object &parent = *s.objects[id], &child = *s.objects[made_id];
  Body& body = *parent.body_of[fragment];
  child.spec = parent.spec;
  child.critical_speed = parent.critical_speed;
  child.asked = true;
  child.fragments = std::move(pieces);
  const FragmentSet& set = child.fragments->set;
  child.body_of.assign(set.fragments.size(), nullptr);
  child.bond_load.assign(set.bonds.size(), -1);
  std::vector<std::uint32_t> members(set.fragments.size());
  for (std::uint32_t k = 0; k < members.size(); ++k) members[k] = k;
  // The hit was hard enough to request this, so the pieces of a single fragment all come apart.
  std::vector<Body*> made = s.spawn(made_id, members, {}, body.asset_to_world(), body.motion());
  Body* const old[] = {&body};
  s.replace(old, made, {.object = made_id, .broken_bonds = set.bonds.size()});
  parent.body_of[fragment] = nullptr;
  s.remove(body);
  s.sweep_out();
  return made_id;
}

}  // namespace fracture::world
