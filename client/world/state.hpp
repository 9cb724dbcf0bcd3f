// The inside of World. Private to this folder.
#pragma once

#include <optional>
#include <span>

#include "client/world/bond_loads.hpp"
#include "client/world/boxed_world.hpp"
#include "client/world/bullet.hpp"
#include "client/world/compound_pairs.hpp"
#include "client/world/ground_pairs.hpp"
#include "client/world/hull_pairs.hpp"
#include "client/world/pair_dispatcher.hpp"

namespace fracture::world {

/// A force on a fragment, in the frame of its asset.
struct PointForce {
  std::uint32_t fragment;
  glm::dvec3 force, point;
  bool hit;  ///< over within the contact time
  Cause cause = Cause::kFall;
};

struct Body {
  enum class Kind { kGround, kStatic, kWhole, kGroup, kBall };
  Kind kind = Kind::kStatic;
  ObjectId object = 0;
  std::unique_ptr<btCollisionShape> shape;  ///< null where the shape belongs to the fragments
  std::vector<std::unique_ptr<btCollisionShape>> children;
  std::unique_ptr<btRigidBody> rigid;
  Pose local;           ///< the body's frame in the asset's
  MassProperties mass;  ///< in the asset's frame
  bool held = false;

  // of a group
  bool crumb = false;  ///< small, and came when there were many: meets no other crumb
  std::uint32_t group = 0;
  std::vector<std::uint32_t> members, bonds;
  std::vector<std::uint32_t> fragment_of_child;
  std::vector<PointForce> forces;     ///< of this step
  double total_force = 0, borne = 0;  ///< of this step; the largest that the bonds were seen to bear

  BallId ball = 0;

  double radius = 0;                 ///< of a sphere around it
  std::uint64_t born = 0;            ///< step
  double lively = 1;                 ///< m/s of its fastest point, averaged over the last steps
  double still = 0;                  ///< seconds for which it has hardly been lively …
  double quiet = 0;                  ///< … and its island on the whole
  double sunk = 0;                   ///< metres that it is inside of others, deepest contact of this step
  std::vector<glm::dvec2> leans_on;  ///< x and z of the contacts of this step that press, from its centre …
  std::optional<bool> tips;          ///< … and whether it tilts over them, where somebody has asked

  // before this step
  glm::dvec3 velocity_before{0}, spin_before{0};
  double kinetic_before = 0;  ///< J
  double stored_before = -1;  ///< J: Object::stored, where a hit of this step raised it; else negative
  double height_before = 0;   ///< State::height()
  std::size_t island = 0;     ///< of this step: equal for what touches, also by way of others; limits.cpp
  bool restore = false;
  double asleep = 0;   ///< seconds
  double fading = -1;  ///< seconds since it began to fade; negative: not yet

  // dozing.cpp
  struct Touched {
    std::uint64_t number;  ///< of a body
    btTransform then;      ///< where it was
    bool bears;            ///< this one, from below
  };
  std::uint64_t number = 0;    ///< of all bodies that there have been
  btTransform watched_from;    ///< where it was …
  double watched = -1;         ///< … so many seconds ago; it has hardly moved since; negative: not seen yet
  bool dozes = false;          ///< sleeps by itself, and is a part of the ground meanwhile
  btVector3 moments{0, 0, 0};  ///< kg·m², while it dozes
  std::vector<Touched> touched;  ///< when it fell asleep; empty while it is awake

  bool asked = false;  ///< has raised kBreakFragment
  bool gone = false;

  bool is_loose() const {
    return !held && (kind == Kind::kWhole || kind == Kind::kGroup || kind == Kind::kBall);
  }
  bool moves() const { return is_loose() && !dozes; }
  Pose body_pose() const { return from_bullet(rigid->getWorldTransform()); }
  Pose asset_to_world() const { return body_pose() * inverse(local); }
  Motion motion() const;
};

struct Object {
  ObjectSpec spec;
  Body* whole = nullptr;
  std::shared_ptr<const PreparedFragments> fragments;
  std::vector<Body*> body_of;    ///< per fragment; null: gone
  std::vector<float> bond_load;  ///< negative: broken
  std::vector<bool> cracked;     ///< which of them are known to be; witness.cpp
  std::vector<Impact> impacts;   ///< since it asked for its fragments
  std::vector<Blast> blasts;     ///< the same, in the frame of the asset; its pieces take them
  double stored = 0;             ///< J: of what the first of them cost, kept for the pieces
  std::uint64_t hit_at = 0;      ///< step of the first of all …
  Cause hit_by = Cause::kFall;   ///< … and what it was
  bool sound = false;            ///< has its fragments, and all their bonds
  /// Has its fragments because a hit was foreseen. Until one comes that would have broken it, it bears what the whole
  /// bears, whatever its bonds are loaded with: a wrong guess changes nothing.
  bool guarded = false;
  bool asked = false, ahead = false;
  std::optional<std::uint64_t> awaited;  ///< step of the hit that is foreseen
  double critical_speed = 1;             ///< strength over mass, m/s

  bool hit() const { return !impacts.empty() || !blasts.empty(); }
};

/// Which of the two lies below the other, where one does: a contact that is not upright enough bears nobody. Null: none.
const Body* bearer(const btPersistentManifold& manifold);

struct World::State {
  explicit State(WorldSettings s);
  ~State();

  struct Hit {  ///< on whole objects and single fragments, summed over the step
    Body* body;
    glm::dvec3 point, impulse;
    double strongest, approach;  ///< N·s, m/s
    double lost;                 ///< J: what became neither motion nor height
    Cause cause;                 ///< of the strongest
  };

  // bodies.cpp
  Body& add(std::unique_ptr<Body> body, btCollisionShape* shape, const PrincipalAxes& axes, const Pose& pose,
            double friction, double restitution);
  Body& add_group(ObjectId object, std::vector<std::uint32_t> members, std::vector<std::uint32_t> bonds,
                  const Pose& asset_to_world);
  void remove(Body& body);
  void sweep_out();  ///< deletes what is gone
  void fade();

  // contacts.cpp
  void collect_contacts();
  void hit_whole(const Hit& hit);
  void raise_impacts();
  void split_overloaded();
  void restore(Body& body) const;  ///< the velocity that it would have without the contacts of this step

  // blast.cpp
  void push(Body& body, const Blast& blast);  ///< as one
  void blast_whole(Body& body, const Blast& blast);
  void blast_group(Body& body, const Blast& blast);
  /// On fragments, all in the frame of the asset.
  std::vector<PointForce> forces_of(const Blast& blast, const FragmentSet& set,
                                    std::span<const std::uint32_t> members) const;

  // limits.cpp
  void keep_above_ground();
  void lower(Body& body, double by) const;
  void limit_gains();  ///< contacts make nothing faster, and nothing more energetic
  void calm();         ///< what almost rests on something, rests

  // dozing.cpp
  void doze();         ///< what lies in a heap
  void rouse() const;  ///< what is hit, or has lost its hold: before contacts are solved
  Body* numbered(std::uint64_t number) const;  ///< null: gone
  void lay(Body& body) const;
  void wake(Body& body) const;  ///< if it dozes
  std::vector<std::uint64_t> bearers();
  /// Before it goes: all that it touches, or only what lies on it.
  void wake_around(const Body& gone, bool only_borne = false);
  void wake_by(Body& struck, double momentum) const;

  // foresight.cpp
  struct Touch {  ///< of this step, both of them bodies of ours
    Body *a, *b;
    bool pressed;              ///< there was an impulse; else they only overlap
    glm::dvec3 point, normal;  ///< in the world, of one contact; from `b` to `a`
  };
  struct Foreseen {
    glm::dvec3 point, push;      ///< in the world; the push on what is asked for, unit length
    double impulse, most;        ///< N·s: of one contact; of all of them at most
    double approach;             ///< m/s
    std::optional<double> time;  ///< s from now, where it is known
  };
  void look_ahead();
  bool is_harmless(const Body& ball) const;
  void ask_ahead(ObjectId object, const Pose& asset_to_world, const Foreseen& hit);
  void ask_again(const Body& ball, const Body& other, const Foreseen& hit);
  void ask_for_neighbours(const Body& body, double impulse, double approach);
  void ask_for_toppling(const Body& body, const Touch& support);

  // ledger.cpp
  double height(const Body& body) const;  ///< J/kg: the potential energy of its centre, above the origin
  double energy(const Body& body) const;  ///< J: kinetic and potential
  void keep_ledger();

  // witness.cpp
  void witness_knocks();
  void witness_cracks();

  // swaps.cpp
  void replace(std::span<Body* const> old, std::span<Body* const> by, Swap swap);
  /// Takes bonds that the forces overload out of `bonds`; returns how many.
  std::size_t break_bonds(Object& object, std::span<const std::uint32_t> members,
                          std::vector<std::uint32_t>& bonds, std::span<const PointForce> forces,
                          const glm::dvec3& gravity);
  /// Of the bonds that have just broken, some hold on while many bodies move: holding.cpp. `before`: all of them, `bonds`:
  /// what is left, ascending. Returns how many.
  std::size_t hold_together(Object& object, std::span<const std::uint32_t> members,
                            std::span<const std::uint32_t> before, std::vector<std::uint32_t>& bonds) const;
  std::vector<Body*> spawn(ObjectId object, std::span<const std::uint32_t> members,
                           std::span<const std::uint32_t> bonds, const Pose& asset_to_world,
                           const Motion& field);
  /// Drives pieces away from a point with so many joules, none of them by more than `fastest` m/s.
  void burst(std::span<Body* const> pieces, const glm::dvec3& point, double energy, double fastest);
  void split(Body& body);

  WorldSettings settings;
  btDefaultCollisionConfiguration configuration;
  std::unique_ptr<HullPair::CreateFunc> hull_pairs;
  GroundPair::CreateFunc ground_pairs;
  std::unique_ptr<CompoundPair::CreateFunc> compound_pairs;
  PairDispatcher dispatcher;
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  BoxedWorld bullet;
  std::unique_ptr<btOverlapFilterCallback> filter;
  std::vector<std::unique_ptr<Body>> bodies;
  std::vector<std::unique_ptr<Object>> objects;
  std::vector<Event> events;
  std::vector<Swap> swaps;
  std::vector<Break> breaks;
  std::uint64_t steps = 0;
  std::uint32_t next_group = 1;
  std::uint64_t next_body = 1;
  BallId next_ball = 1;
  std::size_t faded = 0;
  std::size_t live = 0;  ///< bodies that were moving at the end of the last step, and what came since

  Ledger ledger;
  double least_level = 0;  ///< J: of Ledger::level(), so far
  std::optional<std::uint64_t>
      awake_since;  ///< step after which not all slept, until it is known what met them
  /// Of this step. Behind split_overloaded() some of their bodies are gone: pointers to compare, not to follow.
  std::vector<Touch> touches;
  bool knocked = false;  ///< a ball or a whole thing has met a piece in this step
  std::vector<Hit> hits;
  Witnessed witnessed;
};

void set_motion(Body& body, const glm::dvec3& velocity, const glm::dvec3& spin);
double kinetic_energy(const Body& body);  ///< J
/// Metres above the ground, of its shape and of its centre of mass, too: that of a ragged piece may lie outside of its
/// hull, which is cut where a neighbour's begins.
double lowest(const Body& body);

}  // namespace fracture::world
