// The game's rigid bodies (Bullet) and what breaks them. Fixed steps, one thread; the same calls give the
// same motion.
//
// An object is whole until fracture() hands over its fragments. From then on it consists of groups of bonded
// fragments; each group is one compound body. A group splits by itself where an impact overloads its bonds: no
// server is needed for that.
//
//   step ── contacts ──> whole objects hit harder than their strength ──> Event::kBreak (asks for fragments)
//                   ──> loads on the bonds of groups ──> broken bonds ──> split
//                   ──> single large fragments hit hard ──> Event::kBreakFragment
//   fracture(object, fragments): the whole body is replaced where and as it moves *now*
//   change(object, fragments): a part of a group is replaced by smaller fragments, before it is hit again
//
// When an impulse breaks bonds, Bullet has computed it against a body that was too heavy, because the group had
// not come apart yet. So we give the bodies that touched their velocities from before the step, and the next
// step solves the impact among the pieces: a ball flies on through a wall and loses only the momentum that the
// masses in its way take. The total momentum stays what it was before the step.
//
// Fragments may be there before the hit, because it was foreseen (foresight.cpp). Until a hit comes that would break the
// whole, its bonds bear everything.
//
// Contacts add no energy and no speed (limits.cpp), and end at the ground (ground_pairs.hpp). What an impact on a
// whole object cost is partly kept for its pieces, which may come later; a Ledger counts all of it.
//
// Bullet runs in double precision. The hulls of neighbouring fragments lie a fraction of a millimetre apart; ten
// metres from the origin floats are a micrometre apart, and GJK and EPA lose three or four digits on slivers.
// In float, touching pieces would jitter, and groups would creep while they should rest. Double costs memory but
// no speed: Bullet's float code has no SIMD on Linux.
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
  /// Seconds in which a hit passes on its impulse; divides impulses into forces on bonds. Hard bodies of some
  /// kilograms take a millisecond (Hertz).
  double contact_time = 1e-3;
  /// Share of the impact's energy that drives the pieces of a loose object apart at the swap, as cracks that
  /// open do. Adds no momentum.
  double burst = 0.05;
  std::size_t max_bodies = 800;  ///< that move; beyond it the smallest loose fragments fade at once
  /// While more than so many move, things come apart into fewer and larger pieces (holding.cpp), small loose fragments
  /// (debris_share) that come meet the ground and what is larger, but not one another, and no loose fragment breaks again.
  std::size_t live_bodies = 120;
  std::size_t max_balls = 24;  ///< beyond it the oldest goes
  /// Of an object's volume: smaller loose fragments that bear nothing fade once they sleep …
  double debris_share = 0.02;
  double fade_after = 6;          ///< … for so many seconds …
  double fade_time = 1;           ///< … within so many
  double secondary_share = 0.04;  ///< of an object's volume: larger loose fragments may break again
  double foresight = 0.5;         ///< seconds that paths of balls and falling things are looked ahead; 0: not
  std::size_t threads = 2;        ///< that look for contacts; the motion is the same with any number
  std::size_t max_witnessed =
      0;  ///< knocks, and cracks, that are kept until they are taken; further ones are not
};

using ObjectId = std::uint32_t;
using BallId = std::uint32_t;

struct ObjectSpec {
  std::vector<Hull> hulls;  ///< what collides while it is whole; in the asset's frame
  MassProperties mass;      ///< in the asset's frame
  Pose pose;                ///< of the asset's frame in the world
  bool held = false;        ///< does not move while it is whole
  double strength = 100;    ///< N·s: a contact with more in one step breaks it
  /// How far (metres) a hit is felt while it lasts, about a millisecond. Sound travels 0.5 km/s through masonry
  /// and timber with their joints, 4 km/s through glass and ceramics. See bond_loads.hpp.
  double reach = 0.5;
  /// A fraction of the largest load. In one round only bonds with more than this fraction break; pieces that
  /// have come off carry no load in the next round. Near 1, cracks stay at the hit (masonry: if all overloaded
  /// bonds broke at once, every wall would fall as a whole); near 0, they do break at once (ceramics shatter).
  double crack_front = 0.4;
  double friction = 0.6, restitution = 0.1;
};

/// In the frame of the asset.
struct Impact {
  glm::dvec3 point{0}, direction{0, -1, 0};  ///< direction: of the push on the object, unit length
  double impulse = 0;                        ///< N·s
  double energy = 0;                         ///< J: half the impulse times the speed of approach
};

struct Event {
  enum class Kind {
    kBreak,          ///< a whole object was hit beyond its strength
    kAhead,          ///< that will probably happen within WorldSettings::foresight: a ball comes, or it falls
    kBreakFragment,  ///< a large single fragment was hit beyond its share of the strength
    kAgain,  ///< a ball will probably hit bonded fragments beyond their strength; said every few steps
  };
  Kind kind;
  ObjectId object;
  std::uint32_t fragment;  ///< index; for kBreakFragment
  Impact impact;
  glm::dvec3 where{0};  ///< of the impact, in the world
  BallId ball = 0;      ///< kAgain
};

/// An impulse away from a point, on everything within a radius: blast.cpp says who gets how much of it.
struct Blast {
  glm::dvec3 point{0};
  double impulse = 0;  ///< N·s: in all directions together
  double radius = 1;   ///< metres
};

/// What comes at an object that breaks.
enum class Cause : std::uint8_t {
  kBall,
  kFall,   ///< it falls on something, or something whole on it
  kPiece,  ///< a piece of something else flies at it
  kBlast,
};

/// A whole object came apart, for tests and figures.
struct Break {
  std::uint64_t step = 0;
  ObjectId object = 0;
  Cause cause = Cause::kFall;
  std::uint64_t late = 0;  ///< steps from the hit that breaks it to its fragments; 0: they were there before
};

/// Two bodies that met, in one step: what is seen and heard of it. Nothing in the world depends on it.
struct Knock {
  struct Side {
    enum class Kind { kFixed, kObject, kBall };  ///< kFixed: the ground, and what stands on it for good
    Kind kind = Kind::kFixed;
    ObjectId object = 0;                      ///< kObject
    std::optional<std::uint32_t> fragment{};  ///< kObject: which was met; absent while it is whole
    double mass = 0;                          ///< kg, of all that moves with it; 0: kFixed
    glm::dvec3 moments{0};                    ///< kg·m², ascending
    bool held = false;
  };
  std::uint64_t step = 0;
  glm::dvec3 point{0}, normal{0, 1, 0};  ///< in the world; from `b` to `a`, unit length
  double impulse = 0;                    ///< N·s
  double approach = 0;                   ///< m/s
  Side a, b;
};

/// A bond that broke, where it was then.
struct Crack {
  std::uint64_t step = 0;
  ObjectId object = 0;
  std::uint32_t bond = 0;
  glm::dvec3 point{0}, normal{0};  ///< in the world; the normal is zero where the two share no plane
  double area = 0;                 ///< m²
  double strength = 0;             ///< newtons
  glm::dvec3 velocity{0};          ///< m/s, of one of its sides there
  double mass = 0;                 ///< kg, of the lighter fragment of the two
  glm::dvec3 moments{0};           ///< kg·m², of that
};

struct Witnessed {
  std::vector<Knock> knocks;
  std::vector<Crack> cracks;
};

/// One replacement of bodies by others, for tests and figures.
struct Swap {
  std::uint64_t step = 0;
  ObjectId object = 0;
  std::size_t fragments = 0, groups = 0, broken_bonds = 0;
  bool held = false;  ///< something static took part: the ground has its share of the momentum
  Momentum before{}, after{};
};

struct FragmentState {
  Pose asset_to_world{};
  float size = 1;  ///< 1 … 0 while it fades
  bool present = true;
  std::uint32_t group = 0;  ///< equal for fragments that move together
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

/// What the whole run shows: physics that gains nothing, and a ground that nothing sinks into.
struct Ledger {
  double brought =
      0;  ///< J: kinetic and potential energy of all objects and balls when they came, without those gone
  double energy = 0;      ///< J: now, with what impacts have stored for pieces that are still to come
  double worst_gain = 0;  ///< J: largest rise of energy − brought above its least value before
  double deepest =
      0;  ///< m: how far below height zero the centre of a fragment has been at the end of a step
  std::uint64_t last_swap = 0;  ///< step
  std::uint64_t last_woken =
      0;  ///< step at which a ball or a whole thing woke fragments that all slept; 0: none has
  std::optional<std::uint64_t> asleep_since;  ///< step from which all fragments sleep
};

/// Fragments with their collision shapes: made on any thread, in the step of one World at a time.
struct PreparedFragments;
std::shared_ptr<const PreparedFragments> prepare(FragmentSet set);
/// `before` with what a further hit changed of it (change.hpp). Errors of apply_change().
Expected<std::shared_ptr<const PreparedFragments>> prepare(
    const std::shared_ptr<const PreparedFragments>& before, FragmentChange change);
const FragmentSet& fragments_of(const PreparedFragments& prepared);
/// Of a change: is this fragment of the set before gone or changed?
bool is_replaced(const PreparedFragments& prepared, std::uint32_t fragment);

/// The convex hull of points with at most `most` of them, for ObjectSpec::hulls.
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

  /// Pushes and breaks what is around: wholes that it hits beyond their strength ask for their fragments, which take it when
  /// they come. The ledger counts what it brings. Nothing where impulse or radius are not positive.
  void explode(const Blast& blast);
  /// Where a straight way first meets a body or the ground.
  std::optional<glm::dvec3> first_met(const glm::dvec3& from, const glm::dvec3& to) const;

  /// Replaces a whole object by its fragments; does nothing where it is broken already. Breaks the bonds that
  /// impacts since the request would have overloaded.
  void fracture(ObjectId object, std::shared_ptr<const PreparedFragments> fragments);
  /// Replaces a loose fragment by pieces of it, which become an object of their own (in the same frame).
  /// Nothing where the fragment is gone.
  std::optional<ObjectId> fracture_fragment(ObjectId object, std::uint32_t fragment,
                                            std::shared_ptr<const PreparedFragments> pieces);

  /// Replaces fragments by what a further hit made of them: of the present ones that prepare() was given as `before`, where
  /// and as they move now. All of those that it replaces have to hang together, by whatever way: a change is all or
  /// nothing, for its new fragments fill the place of the old ones together, and what has come loose is elsewhere. Else
  /// false, and nothing happens.
  bool change(ObjectId object, std::shared_ptr<const PreparedFragments> changed);
  /// How many fragments that hang together with this one have their centres within `radius` metres of a point, in the
  /// asset's frame; 0 for one that is gone.
  std::size_t bonded_within(ObjectId object, std::uint32_t fragment, const glm::dvec3& point,
                            double radius) const;

  /// While it is whole: it is so many times as heavy as it was taken for, and bears as much more. It moves as before.
  void scale_mass(ObjectId object, double factor);
  /// It is whole, and was hit beyond its strength or will be within a few steps: now is the time for its fragments.
  bool expects_hit(ObjectId object) const;
  /// The request for its fragments came to nothing: the next hit may ask again.
  void ask_again(ObjectId object);

  void step();
  std::uint64_t steps() const;
  std::vector<Event> take_events();
  std::vector<Swap> take_swaps();
  /// Once for each object: when its fragments come after the hit, or when the first bond breaks of those that were there.
  std::vector<Break> take_breaks();
  /// Since the last call, at most WorldSettings::max_witnessed of each.
  Witnessed take_witnessed();

  bool is_whole(ObjectId object) const;
  Pose object_pose(ObjectId object) const;  ///< while it is whole
  bool stands(ObjectId object) const;       ///< it is whole and hardly moves
  /// Empty while it is whole.
  void fragment_states(ObjectId object, std::vector<FragmentState>& states) const;
  /// Load over strength at the last evaluation, for each bond; negative for a broken one.
  std::vector<float> bond_states(ObjectId object) const;
  std::vector<BallState> balls() const;
  Momentum total_momentum() const;
  Census census() const;
  const Ledger& ledger() const;
  /// Positions, rotations and velocities of all bodies, exactly: equal for equal histories.
  std::uint64_t fingerprint() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fracture::world
