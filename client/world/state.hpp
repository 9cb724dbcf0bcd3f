// World's internal state. Private to this folder.
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
  bool hit;  ///< ends within the contact time
  Cause cause = Cause::kFall;
};

struct Body {
  enum class Kind { kGround, kStatic, kWhole, kGroup, kBall };
  Kind kind = Kind::kStatic;
  ObjectId object = 0;
  std::unique_ptr<btCollisionShape> shape;  ///< null if the fragments own the shape
  std::vector<std::unique_ptr<btCollisionShape>> children;
  std::unique_ptr<btRigidBody> rigid;
  Pose local;           ///< the body's frame in the asset's
  MassProperties mass;  ///< in the asset's frame
  bool held = false;

  // of a group
  bool crumb = false;  ///< small, and created while many bodies moved: collides with no other crumb
  std::uint32_t group = 0;
  std::vector<std::uint32_t> members, bonds;
  std::vector<std::uint32_t> fragment_of_child;
  std::vector<PointForce> forces;     ///< of this step
  double total_force = 0, borne = 0;  ///< in this step; the largest that its bonds have withstood

  BallId ball = 0;

  double radius = 0;                 ///< of the bounding sphere
  std::uint64_t born = 0;            ///< step
  double lively = 1;                 ///< m/s of its fastest point, averaged over recent steps
  double still = 0;                  ///< seconds since it was last lively …
  double quiet = 0;                  ///< … and since its island was, as a whole
  double sunk = 0;                   ///< metres: depth of this step's deepest contact with others
  std::vector<glm::dvec2> leans_on;  ///< x and z of this step's pressing contacts, relative to its centre …
  std::optional<bool> tips;          ///< … and whether it tilts over them; computed on demand

  // before this step
  glm::dvec3 velocity_before{0}, spin_before{0};
  double kinetic_before = 0;  ///< J
  double stored_before = -1;  ///< J: Object::stored before a hit of this step raised it; negative: none did
  double height_before = 0;   ///< State::height()
  std::size_t island = 0;     ///< the same for bodies that touch in this step, directly or not; limits.cpp
  bool restore = false;
  double asleep = 0;   ///< seconds
  double fading = -1;  ///< seconds since it began to fade; negative: not yet

  // dozing.cpp
  struct Touched {
    std::uint64_t number;  ///< number of a body
    btTransform then;      ///< its position at that time
    bool bears;            ///< whether it supports this one from below
  };
  std::uint64_t number = 0;    ///< counts all bodies ever created
  btTransform watched_from;    ///< position …
  double watched = -1;         ///< … this many seconds ago, hardly changed since; negative: not watched yet
  bool dozes = false;          ///< sleeps alone, as part of the ground
  btVector3 moments{0, 0, 0};  ///< kg·m²; set while it dozes
  std::vector<Touched> touched;  ///< when it fell asleep; empty while awake

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
  std::vector<Body*> body_of;    ///< by fragment; null: gone
  std::vector<float> bond_load;  ///< negative: broken
  std::vector<bool> cracked;     ///< bonds known to have cracked; witness.cpp
  std::vector<Impact> impacts;   ///< since its fragments were requested
  std::vector<Blast> blasts;     ///< since then, in the asset's frame; applied to the pieces
  double stored = 0;             ///< J: energy of the first impact, kept for the pieces
  std::uint64_t hit_at = 0;      ///< step of the first hit …
  Cause hit_by = Cause::kFall;   ///< … and its cause
  bool sound = false;            ///< has its fragments, with all bonds intact
  /// Has its fragments because a hit was predicted. Until a hit would have broken the whole, it withstands
  /// what the whole withstands, whatever the loads on its bonds. So a wrong prediction changes nothing.
  bool guarded = false;
  bool asked = false, ahead = false;
  std::optional<std::uint64_t> awaited;  ///< step of the predicted hit
  double critical_speed = 1;             ///< strength over mass, m/s

  bool hit() const { return !impacts.empty() || !blasts.empty(); }
};

/// The body that supports the other, or null if the contact is not upright enough.
const Body* bearer(const btPersistentManifold& manifold);

struct World::State {
  explicit State(WorldSettings s);
  ~State();

  struct Hit {  ///< on whole objects and single fragments, summed over the step
    Body* body;
    glm::dvec3 point, impulse;
    double strongest, approach;  ///< N·s, m/s
    double lost;                 ///< J: energy that became neither motion nor height
    Cause cause;                 ///< of the strongest contact
  };

  // bodies.cpp
  Body& add(std::unique_ptr<Body> body, btCollisionShape* shape, const PrincipalAxes& axes, const Pose& pose,
            double friction, double restitution);
  Body& add_group(ObjectId object, std::vector<std::uint32_t> members, std::vector<std::uint32_t> bonds,
                  const Pose& asset_to_world);
  void remove(Body& body);
  void sweep_out();  ///< deletes bodies that are gone
  void fade();

  // contacts.cpp
  void collect_contacts();
  void hit_whole(const Hit& hit);
  void raise_impacts();
  void split_overloaded();
  void restore(Body& body) const;  ///< sets the velocity that it would have without this step's contacts

  // blast.cpp
  void push(Body& body, const Blast& blast);  ///< as one rigid body
  void blast_whole(Body& body, const Blast& blast);
  void blast_group(Body& body, const Blast& blast);
  /// Forces on fragments, all in the asset's frame.
  std::vector<PointForce> forces_of(const Blast& blast, const FragmentSet& set,
                                    std::span<const std::uint32_t> members) const;

  // limits.cpp
  void keep_above_ground();
  void lower(Body& body, double by) const;
  void limit_gains();  ///< contacts must not add speed or energy
  void calm();         ///< lets bodies rest that lie almost still on something

  // dozing.cpp
  void doze();         ///< lets resting pieces of a heap doze
  void rouse() const;  ///< wakes pieces that are hit or lost their support, before contacts are solved
  Body* numbered(std::uint64_t number) const;  ///< null: it is gone
  void lay(Body& body) const;
  void wake(Body& body) const;  ///< does nothing unless it dozes
  std::vector<std::uint64_t> bearers();
  /// Wakes all bodies that touch it, or only those on top of it, before it is removed.
  void wake_around(const Body& gone, bool only_borne = false);
  void wake_by(Body& struck, double momentum) const;

  // foresight.cpp
  struct Touch {  ///< in this step, between two bodies of this world
    Body *a, *b;
    bool pressed;              ///< there was an impulse; false: they only overlap
    glm::dvec3 point, normal;  ///< of one contact, in the world; the normal points from `b` to `a`
  };
  struct Foreseen {
    glm::dvec3 point, push;      ///< in the world; the push on the object to request, unit length
    double impulse, most;        ///< N·s: of one contact; upper bound for all contacts
    double approach;             ///< m/s
    std::optional<double> time;  ///< seconds from now, if known
  };
  void look_ahead();
  bool is_harmless(const Body& ball) const;
  void ask_ahead(ObjectId object, const Pose& asset_to_world, const Foreseen& hit);
  void ask_again(const Body& ball, const Body& other, const Foreseen& hit);
  void ask_for_neighbours(const Body& body, double impulse, double approach);
  void ask_for_toppling(const Body& body, const Touch& support);

  // ledger.cpp
  double height(const Body& body) const;  ///< J/kg: potential energy of its centre, relative to the origin
  double energy(const Body& body) const;  ///< J: kinetic and potential
  void keep_ledger();

  // witness.cpp
  void witness_knocks();
  void witness_cracks();

  // swaps.cpp
  void replace(std::span<Body* const> old, std::span<Body* const> by, Swap swap);
  /// Removes bonds that the forces overload from `bonds`. Returns their number.
  std::size_t break_bonds(Object& object, std::span<const std::uint32_t> members,
                          std::vector<std::uint32_t>& bonds, std::span<const PointForce> forces,
                          const glm::dvec3& gravity);
  /// Restores some of the bonds that have just broken while many bodies move (holding.cpp). `before`: all
  /// bonds, `bonds`: those left, ascending. Returns the number of restored bonds.
  std::size_t hold_together(Object& object, std::span<const std::uint32_t> members,
                            std::span<const std::uint32_t> before, std::vector<std::uint32_t>& bonds) const;
  std::vector<Body*> spawn(ObjectId object, std::span<const std::uint32_t> members,
                           std::span<const std::uint32_t> bonds, const Pose& asset_to_world,
                           const Motion& field);
  /// Drives pieces away from a point with this energy in joules, but none by more than `fastest` m/s.
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
  std::size_t live = 0;  ///< bodies moving at the end of the last step, plus those added since

  Ledger ledger;
  double least_level = 0;                    ///< J: lowest Ledger level so far
  std::optional<std::uint64_t> awake_since;  ///< step at which they woke, until a hit explains it
  /// This step's contacts. After split_overloaded() some of the bodies are gone, so only compare these
  /// pointers, never follow them.
  std::vector<Touch> touches;
  bool knocked = false;  ///< whether a ball or a whole object has hit a piece in this step
  std::vector<Hit> hits;
  Witnessed witnessed;
};

void set_motion(Body& body, const glm::dvec3& velocity, const glm::dvec3& spin);
double kinetic_energy(const Body& body);  ///< J
/// Height in metres above the ground of the lowest point, counting its shape and its centre of mass. The
/// centre of a ragged piece may lie outside its hull, which ends where its neighbour's hull begins.
double lowest(const Body& body);

}  // namespace fracture::world
