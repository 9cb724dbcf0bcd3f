// The game's rigid bodies (Bullet) and what breaks them. Fixed steps, one thread; the same calls give the
// same motion.
//
// An object is whole until somebody hands over its fragments; then it is groups of bonded fragments, each
// group one compound body, and groups split for themselves where an impact overloads their bonds: no server
// is asked for that.
//
//   step ── contacts ──> whole objects hit harder than their strength ──> Event::kBreak (asks for fragments)
//                   ──> loads on the bonds of groups ──> broken bonds ──> split
//                   ──> single large fragments hit hard ──> Event::kBreakFragment
//   fracture(object, fragments): the whole body is replaced where and as it moves *now*
//
// An impulse that broke bonds was computed against a body that was too heavy: its group had not come apart
// yet. So the bodies that touched get back the velocities from before the step, and the next step solves the
// impact among the pieces: a ball goes on through a wall, slowed by the masses that it really moves. Momentum
// is that from before the step.
//
// Bullet in double precision: hulls of neighbouring fragments lie a fraction of a millimetre apart. Ten
// metres from the origin floats are a micrometre apart, and GJK and EPA lose three or four digits on slivers:
// touching pieces would jitter and groups creep while they should rest. Double costs memory; Bullet's float
// code has no SIMD on Linux that it would forgo.
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
  /// Seconds within which a hit passes on its impulse; with it impulses become forces on bonds. A millisecond
  /// is what hard bodies of some kilograms take (Hertz).
  double contact_time = 1e-3;
  /// Share of the impact's energy that drives the pieces of a loose object apart at the swap: what its cracks
  /// set free. Adds no momentum.
  double burst = 0.05;
  std::size_t max_bodies = 800;   ///< that move; beyond it the smallest loose fragments fade at once
  std::size_t max_balls = 24;     ///< beyond it the oldest goes
  double debris_share = 0.02;     ///< of an object's volume: smaller loose fragments fade once they sleep …
  double fade_after = 6;          ///< … for so many seconds …
  double fade_time = 1;           ///< … within so many
  double secondary_share = 0.04;  ///< of an object's volume: larger loose fragments may break again
  double foresight = 0.5;         ///< seconds that a ball's path is looked ahead for Event::kAhead; 0: not
};

using ObjectId = std::uint32_t;
using BallId = std::uint32_t;

struct ObjectSpec {
  std::vector<Hull> hulls;  ///< what collides while it is whole; in the asset's frame
  MassProperties mass;      ///< in the asset's frame
  Pose pose;                ///< of the asset's frame in the world
  bool held = false;        ///< does not move while it is whole
  double strength = 100;    ///< N·s: a contact with more in one step breaks it
  /// Metres that a hit is felt within its duration of about a millisecond: sound goes 0.5 km/s through
  /// masonry and timber with their joints, 4 km/s through glass and ceramics. See bond_loads.hpp.
  double reach = 0.5;
  /// Of the largest load: in one round only bonds beyond it break, and what has come off carries no load
  /// farther. Near 1 cracks stay at the hit (masonry, where breaking all that is overloaded would fell every
  /// wall as a whole); near 0 all that is overloaded breaks at once (ceramics shatter).
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
    kAhead,          ///< a ball will probably do that within WorldSettings::foresight
    kBreakFragment,  ///< a large single fragment was hit beyond its share of the strength
  };
  Kind kind;
  ObjectId object;
  std::uint32_t fragment;  ///< index; for kBreakFragment
  Impact impact;
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

/// Fragments with their collision shapes: made on any thread, used by one World at a time.
struct PreparedFragments;
std::shared_ptr<const PreparedFragments> prepare(FragmentSet set);
const FragmentSet& fragments_of(const PreparedFragments& prepared);

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

  /// Replaces a whole object by its fragments; nothing happens where it is broken already. Impacts since it
  /// asked for them are made up for: bonds that they would have overloaded are broken.
  void fracture(ObjectId object, std::shared_ptr<const PreparedFragments> fragments);
  /// Replaces a loose fragment by pieces of it, which become an object of their own (in the same frame).
  /// Nothing where the fragment is gone.
  std::optional<ObjectId> fracture_fragment(ObjectId object, std::uint32_t fragment,
                                            std::shared_ptr<const PreparedFragments> pieces);

  /// The request for its fragments came to nothing: the next hit may ask again.
  void ask_again(ObjectId object);

  void step();
  std::uint64_t steps() const;
  std::vector<Event> take_events();
  std::vector<Swap> take_swaps();

  bool is_whole(ObjectId object) const;
  Pose object_pose(ObjectId object) const;  ///< while it is whole
  /// Empty while it is whole.
  void fragment_states(ObjectId object, std::vector<FragmentState>& states) const;
  /// Load over strength at the last evaluation, for each bond; negative for a broken one.
  std::vector<float> bond_states(ObjectId object) const;
  std::vector<BallState> balls() const;
  Momentum total_momentum() const;
  Census census() const;
  /// Positions, rotations and velocities of all bodies, exactly: equal for equal histories.
  std::uint64_t fingerprint() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fracture::world
