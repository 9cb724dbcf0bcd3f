// The rules: what is asked of the server when, and what its answers do to the world. No window, no OpenGL.
//
// In real time nothing waits: advance() runs the steps that are due, polls, and applies what had been decoded
// by the frame before (one answer a frame): coming() shows it to whoever draws while there is still time to
// upload it. With GameSettings::fixed_latency the run is reproducible instead: an answer is
// applied exactly so many steps after its request. Should the server be slower than that, simulated time
// stands still until it has answered (ready() is false); should it be faster, the answer is kept. What the
// server says depends only on what it is asked, that only on the motion before it, and the motion only on the
// steps: identical runs for identical seeds.
#pragma once

#include <map>
#include <optional>

#include "client/game/decoder.hpp"
#include "client/protocol/client.hpp"
#include "client/scenes/scene.hpp"
#include "client/world/world.hpp"

namespace fracture::game {

struct GameSettings {
  std::uint64_t seed = 1;
  std::optional<unsigned> fixed_latency;  ///< steps from a request to its answer's effect
  bool anticipate = true;                 ///< asks when a ball is on its way, not only at the contact
  std::size_t max_requests = 8;           ///< open at the same time; further hits ask later
  nlohmann::json overrides = nlohmann::json::object();  ///< parameters from the panel
  world::WorldSettings world;
};

/// What stands where, for whoever draws.
struct Thing {
  world::ObjectId id = 0;
  std::size_t scene_object = 0;  ///< index into Scene::objects; secondary pieces have their parent's
  std::string mesh;              ///< id of the stored mesh
  std::shared_ptr<const Decoded> fragments;  ///< null while whole
  nlohmann::json parameters;                 ///< of the request that made the fragments
  bool secondary = false;
};

struct GameFigures {
  std::uint64_t requests = 0, answers = 0, failures = 0, swaps = 0, secondary = 0, held_steps = 0;
  std::string last_trouble;
  double worst_momentum_error = 0;  ///< of all swaps without anchors, relative: linear and angular
};

class Game {
 public:
  /// Stores the meshes and asks for what the level needs at its start. `client` outlives the game.
  Game(scenes::Scene scene, protocol::Client& client, GameSettings settings);
  ~Game();

  /// Reproducible runs: is everything there that the next step needs? Polls; never waits.
  bool ready();
  /// One step of WorldSettings::step. Reproducible runs: only when ready().
  void step();
  /// Real time: as many steps as `seconds` hold (at most 6; the rest is dropped), or none while paused.
  void advance(double seconds, bool running);

  world::BallId throw_ball(const glm::dvec3& from, const glm::dvec3& velocity);

  const scenes::Scene& scene() const { return scene_; }
  const std::vector<Thing>& things() const { return things_; }
  /// Fragments that have arrived and take effect in a coming frame, of a thing (for pieces: of their parent).
  struct Coming {
    std::size_t thing;
    std::shared_ptr<const Decoded> fragments;
  };
  std::vector<Coming> coming() const;
  const world::World& world() const { return world_; }
  const GameFigures& figures() const { return figures_; }
  const std::vector<world::Swap>& swaps() const { return swaps_; }  ///< all since the start
  GameSettings& settings() { return settings_; }
  std::size_t open_requests() const { return pending_.size(); }
  /// The last answer, for saving; null before the first.
  std::shared_ptr<const std::string> last_glb() const { return last_glb_; }
  std::size_t meshes_stored() const { return meshes_stored_; }
  /// What the server answered to Client::patterns(), which whoever wants it has asked; empty before.
  const std::string& patterns() const { return patterns_; }

 private:
  struct Pending {
    std::size_t thing = 0;
    std::optional<std::uint32_t> fragment;  ///< secondary
    std::uint64_t due = 0;                  ///< step; fixed_latency alone
    nlohmann::json parameters;
    std::shared_ptr<const Decoded> decoded;
    bool failed = false;
    bool finished() const { return failed || decoded; }
  };

  void poll();
  void ask(std::size_t thing, const world::Impact& impact, std::optional<std::uint32_t> fragment);
  void apply(Pending& pending);
  bool apply_due();  ///< whether bodies were swapped
  void take_events();
  void note_failure(Pending& pending, const std::string& what);
  std::size_t thing_of(world::ObjectId object) const;

  scenes::Scene scene_;
  protocol::Client& client_;
  GameSettings settings_;
  world::World world_;
  Decoder decoder_;
  std::vector<Thing> things_;
  std::map<protocol::Ticket, Pending> pending_;
  std::vector<world::Swap> swaps_;
  GameFigures figures_;
  std::shared_ptr<const std::string> last_glb_;
  std::uint64_t asked_ = 0;
  std::size_t next_throw_ = 0, meshes_stored_ = 0;
  std::string patterns_;
  double owed_ = 0;  ///< seconds not yet simulated
};

}  // namespace fracture::game
