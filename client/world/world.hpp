// The game's rigid bodies (Bullet) and the rules by which they break. Steps are fixed, and one thread may
// call this. The same calls give the same motion.
//
// An object is whole until fracture() supplies its fragments. From then on it consists of groups of bonded
// fragments; each group is one compound body. A group splits on its own if an impact overloads its bonds, without
// a server.
//
//   step ── contacts ──> whole objects hit harder than their strength ──> Event::kBreak (asks for fragments)
//                   ──> loads on the bonds of groups ──> broken bonds ──> split
//                   ──> single large fragments hit hard ──> Event::kBreakFragment
//   fracture(object, fragments): the whole body is replaced where and as it moves *now*
//   change(object, fragments): a part of a group is replaced by smaller fragments, before it is hit again
//
// When an impulse breaks bonds, Bullet has computed it for a body that was too heavy, because the group had
// not come apart yet. So we reset the touching bodies to their velocities from before the step. The next
// step resolves the impact among the pieces: a ball flies on through a wall and loses only the momentum that the
// masses in its path absorb. The total momentum stays the same as before the step.
//
// Fragments may arrive before a predicted hit (foresight.cpp). Until a hit would break the
// whole object, its bonds withstand everything.
//
// Contacts add neither energy nor speed (limits.cpp), and nothing sinks below the ground (ground_pairs.hpp). Part of the
// energy of an impact on a whole object is kept for its pieces, which may arrive later; a Ledger records everything.
//
// Bullet runs in double precision. The hulls of adjacent fragments are a fraction of a millimetre apart. Ten
// metres from the origin, floats are a micrometre apart, and GJK and EPA lose three or four digits on slivers.
// In float, touching pieces would jitter, and groups would creep instead of resting. Double precision costs memory but
// no speed, because Bullet's float code has no SIMD on Linux.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "client/world/fragments.hpp"

namespace fracture::world {

struct Pose {
  glm::dvec3 position{0};
  glm::dquat rotation{1, 0, 0, 0};
  glm::dvec3 point(const glm::dvec3& local) const { return rotation * local + position; }
  glm::dvec3 local(const glm::dvec3& point) const { return glm::conjugate(rotation) * (point - position); }
  glm::dmat4 matrix() const;
};
Pose operator*(const Pose& a, const Pose& b);  ///< first b, then a
Pose inverse(const Pose& pose);

struct WorldSettings {
  glm::dvec3 gravity{0, -9.81, 0};
  double step = 1.0 / 120;  ///< seconds
  double ground_friction = 0.8;
  /// Duration of a hit in seconds; divides impulses to get forces on bonds. Hard bodies of a few
  /// kilograms take a millisecond (Hertz).
  double contact_time = 1e-3;
  /// Share of the impact's energy that pushes the pieces of a loose object apart at the swap, like opening
  /// cracks. Adds no momentum.
  double burst = 0.05;
  std::size_t max_bodies = 800;  ///< maximum that move; beyond it, the smallest loose fragments fade at once
  /// While more bodies than this move, things break into fewer, larger pieces (holding.cpp), and loose
  /// fragments do not break again. New small loose fragments (debris_share) then collide with the ground and
  /// larger bodies, but not with one another.
  std::size_t live_bodies = 120;
  std::size_t max_balls = 24;  ///< beyond it, the oldest ball is removed
  /// Share of an object's volume: smaller loose fragments that support nothing fade once they have slept …
  double debris_share = 0.02;
  double fade_after = 6;          ///< … for this many seconds …
  double fade_time = 1;           ///< … and take this long to fade
  double secondary_share = 0.04;  ///< share of an object's volume: larger loose fragments may break again
  double foresight = 0.5;         ///< seconds by which paths of balls and falls are predicted; 0: none
  std::size_t threads = 2;        ///< number that search for contacts; the motion does not depend on it
  std::size_t max_witnessed =
      0;  ///< maximum number of knocks, and of cracks, kept until they are taken; further ones are dropped
};

using ObjectId = std::uint32_t;
using BallId = std::uint32_t;

struct ObjectSpec {
  std::vector<Hull> hulls;  ///< collision shapes while it is whole; in the asset's frame
  MassProperties mass;      ///< in the asset's frame
  Pose pose;                ///< of the asset's frame in the world
  bool held = false;        ///< does not move while it is whole
  double strength = 100;    ///< N·s: a contact with a larger impulse in one step breaks it
  /// How far (metres) a hit spreads while it lasts, about a millisecond. Sound travels at 0.5 km/s through masonry
  /// and timber with their joints, and at 4 km/s through glass and ceramics. See bond_loads.hpp.
  double reach = 0.5;
  /// A fraction of the largest load. In each round only bonds above this fraction break; pieces that
  /// have come off carry no load in the next round. Near 1, cracks stay close to the hit (masonry: if all overloaded
  /// bonds broke at once, every wall would collapse as a whole); near 0, they all break at once (ceramics shatter).
  double crack_front = 0.4;
  double friction = 0.6, restitution = 0.1;
};

/// In the asset's frame.
struct Impact {
  glm::dvec3 point{0}, direction{0, -1, 0};  ///< direction: of the push on the object, unit length
  double impulse = 0;                        ///< N·s
  double energy = 0;                         ///< J: half the impulse times the approach speed
};

struct Event {
  enum class Kind {
    kBreak,          ///< a whole object was hit beyond its strength
    kAhead,          ///< it will probably be hit that hard within WorldSettings::foresight
    kBreakFragment,  ///< a large single fragment was hit beyond its share of the strength
    kAgain,  ///< a ball will probably hit bonded fragments beyond their strength; repeated every few steps
  };
  Kind kind;
  ObjectId object;
  std::uint32_t fragment;  ///< index; for kBreakFragment
  Impact impact;
  glm::dvec3 where{0};  ///< the impact, in the world
  BallId ball = 0;      ///< kAgain
};

/// An impulse away from a point, on everything within a radius; blast.cpp distributes it.
struct Blast {
  glm::dvec3 point{0};
  double impulse = 0;  ///< N·s: the total in all directions
  double radius = 1;   ///< metres
};

/// The cause of a break.
enum class Cause : std::uint8_t {
  kBall,
  kFall,   ///< it falls on something, or something whole falls on it
  kPiece,  ///< a piece of another object hits it
  kBlast,
};

/// A whole object that broke, for tests and statistics.
struct Break {
  std::uint64_t step = 0;
  ObjectId object = 0;
  Cause cause = Cause::kFall;
  std::uint64_t late = 0;  ///< steps from the hit that breaks it to its fragments; 0: they were ready
};

/// A contact of two bodies in one step, to be seen and heard. Nothing in the world depends on it.
struct Knock {
  struct Side {
    enum class Kind { kFixed, kObject, kBall };  ///< kFixed: the ground, and everything fixed to it
    Kind kind = Kind::kFixed;
    ObjectId object = 0;                      ///< kObject
    std::optional<std::uint32_t> fragment{};  ///< kObject: the one that was hit; absent if whole
    double mass = 0;                          ///< kg, of everything that moves with it; 0: kFixed
    glm::dvec3 moments{0};                    ///< kg·m², ascending
    bool held = false;
  };
  std::uint64_t step = 0;
  glm::dvec3 point{0}, normal{0, 1, 0};  ///< in the world; from `b` to `a`, unit length
  double impulse = 0;                    ///< N·s
  double approach = 0;                   ///< m/s
  Side a, b;
};

/// A bond that broke, at its position at that time.
struct Crack {
  std::uint64_t step = 0;
  ObjectId object = 0;
  std::uint32_t bond = 0;
  glm::dvec3 point{0}, normal{0};  ///< in the world; the normal is zero if the two share no plane
  double area = 0;                 ///< m²
  double strength = 0;             ///< newtons
  glm::dvec3 velocity{0};          ///< m/s, of one of its sides at that point
  double mass = 0;                 ///< kg, of the lighter of the two fragments
  glm::dvec3 moments{0};           ///< kg·m², of the same fragment
};

struct Witnessed {
  std::vector<Knock> knocks;
  std::vector<Crack> cracks;
};

/// The replacement of bodies by others, for tests and statistics.
struct Swap {
  std::uint64_t step = 0;
  ObjectId object = 0;
  std::size_t fragments = 0, groups = 0, broken_bonds = 0;
  bool held = false;  ///< something static was involved: the ground absorbed part of the momentum
  Momentum before{}, after{};
};

struct FragmentState {
  Pose asset_to_world{};
  float size = 1;  ///< 1 … 0 while it fades
  bool present = true;
  std::uint32_t group = 0;  ///< the same for fragments that move together
};

struct BallState {
  BallId id;
  Pose pose;
  double radius;
};

struct Census {
  std::size_t bodies = 0, moving = 0, whole = 0, groups = 0, fragments = 0, bonds = 0, balls = 0, faded = 0;
  double fastest = 0;  ///< m/s, without balls
  double lowest = 0;   ///< y of the lowest point of any hull
};

/// Properties of the whole run: no energy is gained, and nothing sinks into the ground.
struct Ledger {
  double brought =
      0;  ///< J: kinetic and potential energy of objects and balls when added, minus those removed
  double energy = 0;      ///< J: now, including energy stored from impacts for pieces still to come
  double worst_gain = 0;  ///< J: largest rise of energy − brought above its previous minimum
  double deepest = 0;     ///< m: greatest depth of a fragment's centre below height zero at the end of a step
  std::uint64_t last_swap = 0;  ///< step
  std::uint64_t last_woken =
      0;  ///< step at which a ball or a whole thing woke fragments while all were asleep; 0: none has
  std::optional<std::uint64_t> asleep_since;  ///< step since which all fragments sleep
};

/// Fragments with their collision shapes: created on any thread, used in the step of one World at a time.
struct PreparedFragments;
std::shared_ptr<const PreparedFragments> prepare(FragmentSet set);
/// `before` with the changes of a further hit (change.hpp). Has the errors of apply_change().
Expected<std::shared_ptr<const PreparedFragments>> prepare(
    const std::shared_ptr<const PreparedFragments>& before, FragmentChange change);
const FragmentSet& fragments_of(const PreparedFragments& prepared);
/// For a change: whether this fragment of the previous set is gone or changed.
bool is_replaced(const PreparedFragments& prepared, std::uint32_t fragment);

/// The convex hull of points, with at most `most` of them, for ObjectSpec::hulls.
Hull reduced_hull(std::span<const glm::vec3> points, std::size_t most = 64);

class World {
 public:
  explicit World(WorldSettings settings = {});
  ~World();
  World(World&&) noexcept;

  const WorldSettings& settings() const;
  ObjectId add_object(const ObjectSpec& spec);
  void add_static_box(const Pose& pose, const glm::dvec3& half_sides);
  BallId throw_ball(const glm::dvec3& from, const glm::dvec3& velocity, double radius, double density);

  /// Pushes and breaks everything around the point. Whole objects hit beyond their strength request their
  /// fragments, which receive the impulse when they arrive. The ledger records the added energy. Does nothing
  /// if impulse or radius is not positive.
  void explode(const Blast& blast);
  /// The first point at which a ray meets a body or the ground.
  std::optional<glm::dvec3> first_met(const glm::dvec3& from, const glm::dvec3& to) const;

  /// Replaces a whole object with its fragments; does nothing if it is already broken. Breaks the bonds that
  /// impacts since the request would have overloaded.
  void fracture(ObjectId object, std::shared_ptr<const PreparedFragments> fragments);
  /// Replaces a loose fragment with its pieces, which become a separate object (in the same frame).
  /// Does nothing if the fragment is gone.
  std::optional<ObjectId> fracture_fragment(ObjectId object, std::uint32_t fragment,
                                            std::shared_ptr<const PreparedFragments> pieces);

  /// Replaces fragments, where and as they move now, with the result of a further hit on the current set,
  /// which prepare() received as `before`. The change is all or nothing, because the new fragments together
  /// fill the place of the old ones. So all replaced fragments must be connected, directly or through others.
  /// Otherwise returns false and changes nothing.
  bool change(ObjectId object, std::shared_ptr<const PreparedFragments> changed);
  /// Number of fragments connected to this one whose centres are within `radius` metres of a point in the
  /// asset's frame; 0 if it is gone.
  std::size_t bonded_within(ObjectId object, std::uint32_t fragment, const glm::dvec3& point,
                            double radius) const;

  /// While it is whole: multiplies its assumed mass and its strength by a factor. Its motion does not change.
  void scale_mass(ObjectId object, double factor);
  /// Whether it is whole and was hit beyond its strength, or will be within a few steps: it needs its fragments now.
  bool expects_hit(ObjectId object) const;
  /// The request for its fragments failed: the next hit may request them again.
  void ask_again(ObjectId object);

  void step();
  std::uint64_t steps() const;
  std::vector<Event> take_events();
  std::vector<Swap> take_swaps();
  /// Once per object: when its fragments arrive after the hit, or when the first bond of ready fragments breaks.
  std::vector<Break> take_breaks();
  /// The events since the last call, at most WorldSettings::max_witnessed of each kind.
  Witnessed take_witnessed();

  bool is_whole(ObjectId object) const;
  Pose object_pose(ObjectId object) const;  ///< while it is whole
  bool stands(ObjectId object) const;       ///< whether it is whole and hardly moves
  /// Empty while it is whole.
  void fragment_states(ObjectId object, std::vector<FragmentState>& states) const;
  /// Load divided by strength of each bond at the last evaluation; negative for a broken bond.
  std::vector<float> bond_states(ObjectId object) const;
  std::vector<BallState> balls() const;
  Momentum total_momentum() const;
  Census census() const;
  const Ledger& ledger() const;
  /// Exact positions, rotations and velocities of all bodies: equal for equal histories.
  std::uint64_t fingerprint() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fracture::world
