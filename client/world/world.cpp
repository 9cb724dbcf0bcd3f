#include "client/world/world.hpp"

#include <BulletCollision/CollisionDispatch/btConvexConvexAlgorithm.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <span>

#include "client/world/state.hpp"

namespace fracture::world {

glm::dmat4 Pose::matrix() const { return glm::translate(glm::dmat4(1), position) * glm::mat4_cast(rotation); }
Pose operator*(const Pose& a, const Pose& b) {
  return {a.point(b.position), glm::normalize(a.rotation * b.rotation)};
}
Pose inverse(const Pose& pose) {
  const glm::dquat back = glm::conjugate(pose.rotation);
  return {back * -pose.position, back};
}

namespace {

/// Fragments may overlap, so the file states which must not collide. Crumbs do not collide with one another.
struct ApartFilter : btOverlapFilterCallback {
  const std::vector<std::unique_ptr<Object>>& objects;
  explicit ApartFilter(const std::vector<std::unique_ptr<Object>>& o) : objects(o) {}

  const Body* body_of(const btBroadphaseProxy* proxy) const {
    const auto* object = static_cast<const btCollisionObject*>(proxy->m_clientObject);
    return object ? static_cast<const Body*>(object->getUserPointer()) : nullptr;
  }
  /// The indices of a body's fragments; none if it is not broken.
  static std::span<const std::uint32_t> fragments_of(const Body& body) {
    return body.kind == Body::Kind::kGroup ? std::span<const std::uint32_t>(body.members)
                                           : std::span<const std::uint32_t>();
  }
  /// After a hit only the newer fragment may name the other.
  static bool names(const Fragment& a, const Fragment& b) {
    return std::binary_search(a.apart.begin(), a.apart.end(), b.id);
  }
  bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override {
    if ((a->m_collisionFilterGroup & b->m_collisionFilterMask) == 0 ||
        (b->m_collisionFilterGroup & a->m_collisionFilterMask) == 0)
      return false;
    const Body *first = body_of(a), *second = body_of(b);
    if (first == nullptr || second == nullptr) return true;
    if (first->crumb && second->crumb) return false;
    if (first->object != second->object) return true;
    return !any_names(*first, *second) && !any_names(*second, *first);
  }
  /// Whether a fragment of `body` lists one of `other`. Linear in the fragments of `body` if none lists any.
  bool any_names(const Body& body, const Body& other) const {
    for (const std::uint32_t f : fragments_of(body)) {
      const std::vector<Fragment>& all = objects[body.object]->fragments->set.fragments;
      if (all[f].apart.empty()) continue;
      for (const std::uint32_t g : fragments_of(other))
        if (names(all[f], all[g])) return true;
    }
    return false;
  }
};

/// Contacts with the ground and fixed objects use the mean, the default of KHR_physics_rigid_bodies. With
/// Bullet's product, ice would slide over stone as easily as over ice. Contacts between pieces use the
/// product, because pieces get stuck where real edges crumble. With the mean, a ball would stick in the hole
/// that it made.
btScalar friction_between(const btCollisionObject* a, const btCollisionObject* b) {
  const auto stands = [](const btCollisionObject* object) {
    const auto* body = static_cast<const Body*>(object->getUserPointer());
    return body != nullptr && (body->kind == Body::Kind::kGround || body->kind == Body::Kind::kStatic);
  };
  return stands(a) || stands(b) ? 0.5 * (a->getFriction() + b->getFriction())
                                : a->getFriction() * b->getFriction();
}

}  // namespace

World::State::State(WorldSettings s)
    : settings(s),
      dispatcher(&configuration, s.threads),
      bullet(&dispatcher, &broadphase, &solver, &configuration) {
  gCalculateCombinedFrictionCallback = friction_between;  // global for all of Bullet, as is the next line
  gDeactivationTime = 0.8;                                // seconds of stillness before sleep
  const auto* theirs =
      static_cast<btConvexConvexAlgorithm::CreateFunc*>(configuration.getCollisionAlgorithmCreateFunc(
          CONVEX_HULL_SHAPE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE));
  hull_pairs = std::make_unique<HullPair::CreateFunc>(theirs->m_pdSolver);
  compound_pairs = std::make_unique<CompoundPair::CreateFunc>(*hull_pairs);
  const auto meet_by = [&](int first, int second, btCollisionAlgorithmCreateFunc& algorithm) {
    dispatcher.registerCollisionCreateFunc(first, second, &algorithm);
    dispatcher.registerCollisionCreateFunc(second, first, &algorithm);
  };
  constexpr int kHull = HullShape::kType, kCompound = COMPOUND_SHAPE_PROXYTYPE, kBox = BOX_SHAPE_PROXYTYPE,
                kPlane = STATIC_PLANE_PROXYTYPE;
  for (const int hull : {kHull, kBox}) {
    meet_by(kHull, hull, *hull_pairs);
    meet_by(kCompound, hull, *compound_pairs);
  }
  meet_by(kCompound, kCompound, *compound_pairs);
  for (const int body : {kHull, kCompound}) meet_by(body, kPlane, ground_pairs);
  bullet.setGravity(to_bullet(settings.gravity));
  bullet.getSolverInfo().m_numIterations = 30;
  // The solver stops when no contact changes a velocity by more than 3 mm/s. In a step, gravity changes it by
  // 27 times that.
  bullet.getSolverInfo().m_leastSquaresResidualThreshold = 1e-5;
  // Corrects penetration without adding speed, because touching fragments must not fly apart.
  bullet.getSolverInfo().m_splitImpulse = true;
  bullet.getSolverInfo().m_splitImpulsePenetrationThreshold = 0;  // even the smallest penetration
  // Overlapping hulls of ragged pieces part slowly, because parting lifts them. Penetration of the ground is
  // corrected at once.
  bullet.getSolverInfo().m_erp2 = 0.2;
  filter = std::make_unique<ApartFilter>(objects);
  bullet.when_contacts_are_found = [this] { rouse(); };
  bullet.getPairCache()->setOverlapFilterCallback(filter.get());
  auto ground = std::make_unique<Body>();
  ground->kind = Body::Kind::kGround;
  ground->shape = std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), 0);
  btCollisionShape* shape = ground->shape.get();
  add(std::move(ground), shape, {}, {}, settings.ground_friction, 0.3);
}

World::State::~State() {
  for (const auto& body : bodies)
    if (!body->gone) bullet.removeRigidBody(body->rigid.get());
}

World::World(WorldSettings settings) : state_(std::make_unique<State>(settings)) {}
World::~World() = default;
World::World(World&&) noexcept = default;

const WorldSettings& World::settings() const { return state_->settings; }
std::uint64_t World::steps() const { return state_->steps; }
std::vector<Event> World::take_events() { return std::exchange(state_->events, {}); }
std::vector<Swap> World::take_swaps() { return std::exchange(state_->swaps, {}); }
std::vector<Break> World::take_breaks() { return std::exchange(state_->breaks, {}); }
Witnessed World::take_witnessed() { return std::exchange(state_->witnessed, {}); }

ObjectId World::add_object(const ObjectSpec& spec) {
  State& s = *state_;
  const auto id = static_cast<ObjectId>(s.objects.size());
  auto object = std::make_unique<Object>();
  object->spec = spec;
  object->critical_speed = spec.strength / std::max(spec.mass.mass, 1e-9);
  auto body = std::make_unique<Body>();
  body->kind = Body::Kind::kWhole;
  body->object = id;
  body->mass = spec.mass;
  body->held = spec.held;
  const PrincipalAxes axes = principal_axes(spec.mass.inertia);
  body->local = {spec.mass.center, axes.rotation};
  std::vector<std::unique_ptr<btCollisionShape>> hulls;
  for (const Hull& hull : spec.hulls) {
    Hull local;
    for (const glm::dvec3& p : hull) local.push_back(body->local.local(p));
    hulls.push_back(make_hull(local));
  }
  btCollisionShape* shape = nullptr;
  if (hulls.size() == 1) {
    body->shape = std::move(hulls[0]);
    shape = body->shape.get();
  } else {
    auto compound = std::make_unique<btCompoundShape>();
    for (const auto& hull : hulls) compound->addChildShape(btTransform::getIdentity(), hull.get());
    body->children = std::move(hulls);
    shape = compound.get();
    body->shape = std::move(compound);
  }
  const Pose pose = spec.pose * body->local;
  s.objects.push_back(std::move(object));
  Body& whole = s.add(std::move(body), shape, axes, pose, spec.friction, spec.restitution);
  s.objects.back()->whole = &whole;
  s.ledger.brought += s.energy(whole);
  return id;
}

void World::add_static_box(const Pose& pose, const glm::dvec3& half_sides) {
  auto body = std::make_unique<Body>();
  body->shape = std::make_unique<btBoxShape>(to_bullet(half_sides));
  btCollisionShape* shape = body->shape.get();
  state_->add(std::move(body), shape, {}, pose, state_->settings.ground_friction, 0.2);
}

BallId World::throw_ball(const glm::dvec3& from, const glm::dvec3& velocity, double radius, double density) {
  State& s = *state_;
  auto body = std::make_unique<Body>();
  body->kind = Body::Kind::kBall;
  body->ball = s.next_ball++;
  body->radius = radius;
  body->born = s.steps;
  const double mass = density * 4.0 / 3.0 * 3.14159265358979323846 * radius * radius * radius;
  body->mass = {mass, glm::dvec3(0), glm::dmat3(0.4 * mass * radius * radius)};
  body->shape = std::make_unique<btSphereShape>(radius);
  btCollisionShape* shape = body->shape.get();
  Body& ball = s.add(std::move(body), shape, {glm::dvec3(0.4 * mass * radius * radius), {1, 0, 0, 0}},
                     {from, {1, 0, 0, 0}}, 0.6, 0.35);
  ball.rigid->setRollingFriction(0.01);
  ball.rigid->setSpinningFriction(0.01);
  // A pane is thinner than the ball's path in a step.
  ball.rigid->setCcdMotionThreshold(0.5 * radius);
  ball.rigid->setCcdSweptSphereRadius(0.7 * radius);
  set_motion(ball, velocity, glm::dvec3(0));
  s.ledger.brought += s.energy(ball);
  return ball.ball;
}

void World::step() {
  State& s = *state_;
  s.live = 0;
  for (const auto& body : s.bodies) {
    s.live += body->moves() && body->rigid->isActive();
    body->velocity_before = from_bullet(body->rigid->getLinearVelocity());
    body->spin_before = from_bullet(body->rigid->getAngularVelocity());
    body->kinetic_before = kinetic_energy(*body);
    body->height_before = s.height(*body);
  }
  s.bullet.stepSimulation(s.settings.step, 0);
  ++s.steps;
  s.collect_contacts();
  s.witness_knocks();
  s.keep_above_ground();
  s.limit_gains();
  s.calm();
  s.doze();
  s.raise_impacts();
  s.split_overloaded();
  s.look_ahead();
  s.fade();
  s.keep_ledger();
  s.witness_cracks();
}

void World::ask_again(ObjectId id) {
  Object& object = *state_->objects.at(id);
  object.asked = object.ahead = false;
  object.awaited.reset();
  object.impacts.clear();
  object.stored = 0;
  // No fragments came for the blast to act on, so it pushes the whole.
  if (object.whole != nullptr)
    for (const Blast& blast : object.blasts)
      state_->push(*object.whole,
                   {object.whole->asset_to_world().point(blast.point), blast.impulse, blast.radius});
  object.blasts.clear();
}

void World::scale_mass(ObjectId id, double factor) {
  Object& object = *state_->objects.at(id);
  if (object.whole == nullptr || !(factor > 0)) return;
  Body& body = *object.whole;
  state_->ledger.brought += (factor - 1) * state_->energy(body);
  object.spec.mass.mass *= factor;
  object.spec.mass.inertia *= factor;
  if (!body.held) object.spec.strength *= factor;  // a held object's strength does not depend on its weight
  body.mass = object.spec.mass;
  if (body.moves())
    body.rigid->setMassProps(body.mass.mass, to_bullet(principal_axes(body.mass.inertia).moments));
  body.rigid->updateInertiaTensor();
}

bool World::is_whole(ObjectId object) const { return state_->objects.at(object)->whole != nullptr; }
bool World::stands(ObjectId object) const {
  constexpr double kStands = 0.05;  // m/s: a falling body exceeds it after one step
  const Body* whole = state_->objects.at(object)->whole;
  return whole != nullptr && glm::length(from_bullet(whole->rigid->getLinearVelocity())) < kStands;
}
Pose World::object_pose(ObjectId object) const {
  const Body* whole = state_->objects.at(object)->whole;
  return whole != nullptr ? whole->asset_to_world() : Pose{};
}

void World::fragment_states(ObjectId id, std::vector<FragmentState>& states) const {
  const Object& object = *state_->objects.at(id);
  states.clear();
  const Body* last = nullptr;
  Pose pose;
  for (const Body* body : object.body_of) {
    if (body == nullptr) {
      states.push_back({.present = false});
      continue;
    }
    if (body != last) pose = body->asset_to_world();
    last = body;
    const double size = body->fading < 0 ? 1 : std::max(0.0, 1 - body->fading / state_->settings.fade_time);
    states.push_back({pose, static_cast<float>(size), true, body->group});
  }
}

std::vector<float> World::bond_states(ObjectId object) const { return state_->objects.at(object)->bond_load; }

std::vector<BallState> World::balls() const {
  std::vector<BallState> result;
  for (const auto& body : state_->bodies)
    if (body->kind == Body::Kind::kBall) result.push_back({body->ball, body->body_pose(), body->radius});
  return result;
}

Momentum World::total_momentum() const {
  std::vector<Motion> all;
  for (const auto& body : state_->bodies)
    if (body->moves()) {
      Motion motion = body->motion();
      all.push_back(motion);
    }
  return momentum(all);
}

Census World::census() const {
  Census c;
  c.lowest = HUGE_VAL;
  c.faded = state_->faded;
  for (const auto& body : state_->bodies) {
    ++c.bodies;
    c.moving += body->moves() && body->rigid->isActive();
    c.whole += body->kind == Body::Kind::kWhole;
    c.groups += body->kind == Body::Kind::kGroup;
    c.balls += body->kind == Body::Kind::kBall;
    c.fragments += body->members.size();
    c.bonds += body->bonds.size();
    if (body->kind == Body::Kind::kGround || body->kind == Body::Kind::kStatic) continue;
    if (body->kind != Body::Kind::kBall && body->moves())
      c.fastest = std::max(c.fastest, glm::length(from_bullet(body->rigid->getLinearVelocity())));
    if (body->kind == Body::Kind::kGroup) {
      const Pose pose = body->asset_to_world();
      for (const std::uint32_t m : body->members)
        for (const Hull& hull : state_->objects[body->object]->fragments->set.fragments[m].hulls)
          for (const glm::dvec3& p : hull) c.lowest = std::min(c.lowest, pose.point(p).y);
    } else {
      c.lowest = std::min(c.lowest, lowest(*body));
    }
  }
  return c;
}

const Ledger& World::ledger() const { return state_->ledger; }

std::uint64_t World::fingerprint() const {
  std::uint64_t hash = 0xcbf29ce484222325ull;  // FNV-1a
  const auto mix = [&](double x) {
    std::uint64_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    for (int k = 0; k < 8; ++k) hash = (hash ^ ((bits >> (8 * k)) & 0xff)) * 0x100000001b3ull;
  };
  for (const auto& body : state_->bodies) {
    const Pose pose = body->body_pose();
    const btVector3 &v = body->rigid->getLinearVelocity(), &w = body->rigid->getAngularVelocity();
    for (const double x :
         {pose.position.x, pose.position.y, pose.position.z, pose.rotation.x, pose.rotation.y,
          pose.rotation.z, pose.rotation.w, v.x(), v.y(), v.z(), w.x(), w.y(), w.z()})
      mix(x);
  }
  return hash;
}

}  // namespace fracture::world
