// The rules: what is asked of the server when, and what its answers do to the world. No window, no OpenGL.
//
// In real time nothing waits: advance() runs the steps that are due, polls, and applies what had been decoded
// by the frame before (one answer a frame): coming() shows it to whoever draws while there is still time to
// upload it. A window has a thread for that, which calls attend() and step() by itself (app/simulation.hpp).
// With GameSettings::fixed_latency the run is reproducible instead: an answer is
// applied exactly so many steps after its request. Should the server be slower than that, simulated time
// stands still until it has answered (ready() is false); should it be faster, the answer is kept. What the
// server says depends only on what it is asked, that only on the motion before it, and the motion only on the
// steps: identical runs for identical seeds.
#pragma once

#include <map>
#include <optional>
#include <set>

#include "client/game/history.hpp"
#include "client/game/recording.hpp"
#include "client/protocol/client.hpp"
#include "client/scenes/scene.hpp"
#include "client/world/world.hpp"

namespace fracture::game {

struct GameSettings {
  std::uint64_t seed = 1;
  std::optional<unsigned> fixed_latency;  ///< steps from a request to its answer's effect
  bool anticipate = true;                 ///< asks when a ball is on its way, not only at the contact
  /// Open at the same time, of what is foreseen in a moment (Game::counted_requests()); further hits wait, the most urgent is next.
  std::size_t max_requests = 8;
  nlohmann::json overrides =
      nlohmann::json::object();  ///< parameters at the start; then Game::set_overrides()
  world::WorldSettings world;
  std::shared_ptr<Recorder> recorder;    ///< of what happens; null: none
  std::shared_ptr<History> history;      ///< the same, in memory; null: none
  std::shared_ptr<KeptAnswers> answers;  ///< to what has been asked before; null: all is asked for
  /// What happens, as it was recorded: until hand_over() it decides when answers take effect.
  std::shared_ptr<const Recording> replay;
};

/// What stands where, for whoever draws.
struct Thing {
  world::ObjectId id = 0;
  std::size_t scene_object = 0;  ///< index into Scene::objects; secondary pieces have their parent's
  std::string mesh;              ///< id of the stored mesh
  std::shared_ptr<const Decoded> fragments;  ///< null while whole
  nlohmann::json parameters;                 ///< of the request that made the fragments, with all hits since
  bool secondary = false;
  std::set<world::BallId> hit_by;  ///< balls whose hits on its fragments have been asked for: once each
};

struct GameFigures {
  std::uint64_t requests = 0, answers = 0, failures = 0, swaps = 0, secondary = 0, held_steps = 0;
  std::uint64_t hits = 0;      ///< further hits that made finer fragments of those that were there …
  std::uint64_t too_late = 0;  ///< … and those whose fragments had come loose before
  std::string last_trouble;
  std::string last_break;            ///< what broke into how many pieces, and how long that took, for people
  double worst_momentum_error = 0;   ///< of all swaps without anchors, relative: linear and angular
  std::vector<world::Break> breaks;  ///< of things whose fragments are not asked for when the level is loaded
  std::optional<std::uint64_t> diverged;  ///< the first step after which a replay was not what was recorded
};

class Game {
 public:
  /// Stores the meshes and asks for what the level needs at its start. `client` outlives the game.
  Game(scenes::Scene scene, protocol::Client& client, GameSettings settings);
  ~Game();

  /// Reproducible runs and replays: is everything there that the next step needs? Polls; never waits.
  bool ready();
  /// One step of WorldSettings::step. Reproducible runs: only when ready().
  void step();
  /// Real time, before each step, and now and then while paused: applies one answer, polls, and asks. Whether bodies were
  /// swapped.
  bool attend();
  /// Real time: as many steps as `seconds` hold (at most 6; the rest is dropped), or none while paused.
  void advance(double seconds, bool running);

  world::BallId throw_ball(const glm::dvec3& from, const glm::dvec3& velocity, const scenes::Ball& ball = {});
  void explode(const world::Blast& blast);

  /// What there was to see and hear since the last call; nothing without WorldSettings::max_witnessed.
  world::Witnessed take_witnessed() { return world_.take_witnessed(); }
  /// By the server's name; empty where the object's request names none.
  std::string material_of(world::ObjectId object) const;

  const scenes::Scene& scene() const { return scene_; }
  const std::vector<Thing>& things() const { return things_; }
  /// Fragments that have arrived and take effect in a coming frame, of a thing (for pieces: of their parent).
  struct Coming {
    std::size_t thing;
    std::size_t scene_object;  ///< of the thing
    std::shared_ptr<const Decoded> fragments;
  };
  std::vector<Coming> coming() const;
  const world::World& world() const { return world_; }
  const GameFigures& figures() const { return figures_; }
  const std::vector<world::Swap>& swaps() const { return swaps_; }  ///< all since the start
  const GameSettings& settings() const { return settings_; }
  std::size_t open_requests() const;  ///< without an answer that can be used
  std::size_t kept_answers() const;   ///< for hits that were foreseen and have not come
  std::size_t waiting_requests() const { return waiting_.size(); }  ///< for one of the open ones to end
  /// From where it is seen: of two equal hits the nearer one is answered first. At first the scene's.
  void set_eye(const glm::dvec3& eye) { eye_ = eye; }
  void set_overrides(nlohmann::json overrides);
  /// Are all steps of the recording played?
  bool replayed() const { return settings_.replay && world_.steps() >= settings_.replay->hashes.size(); }
  /// Ends the replay: what comes next is a game like any other, with the answers that are still awaited.
  void hand_over();
  /// Throws what the scene throws by itself, up to a time in seconds. Reproducible runs do so in step().
  void throw_scripted(double until);
  /// The last whole answer, for saving; null before the first.
  std::shared_ptr<const std::string> last_glb() const { return last_glb_; }
  std::size_t meshes_stored() const { return meshes_stored_; }
  /// What the server answered to Client::patterns(), which whoever wants it has asked; empty before.
  const std::string& patterns() const { return patterns_; }

 private:
  struct Pending {
    protocol::Ticket ticket = 0;  ///< 0: the answer was kept
    std::size_t thing = 0;
    std::optional<std::uint32_t> fragment;  ///< secondary
    nlohmann::json wanted;                  ///< what is asked for, in full
    nlohmann::json parameters;              ///< of all fragments when it has taken effect
    /// A further hit: what it is a change of. Where the server knows the answer before by its name no more, it is asked
    /// for `wanted`.
    std::shared_ptr<const Decoded> before;
    bool by_name = false;
    std::string location;   ///< of the answer
    std::uint64_t due = 0;  ///< step; fixed_latency alone
    std::shared_ptr<const Decoded> decoded;
    double milliseconds = 0;     ///< from asking to the answer
    std::uint64_t asked_at = 0;  ///< step
    bool ahead = false;          ///< asked for before a hit: kept until World::expects_hit()
    bool failed = false;
    bool finished() const { return failed || decoded; }
  };

  /// A hit that is to be asked for.
  struct Waiting {
    std::size_t thing = 0;
    std::optional<std::uint32_t> fragment{};
    world::Impact impact{};
    double urgency = 0;
    bool ahead = false;
    bool again = false;  ///< a further hit on its fragments
  };
  using Requests = std::map<std::uint64_t, Pending>;  ///< by their numbers, from 1, in the order of asking

  void poll();
  void want(const Waiting& hit);  ///< keeps the more urgent of two for the same thing
  void ask_most_urgent();         ///< as many as may be open
  void ask(const Waiting& hit);
  /// Would a further hit make finer fragments than there are, and has nobody asked for it?
  bool wants_again(const Thing& thing, const world::Event& event) const;
  /// The server does not know the answer any more that the request names: asks for the same by its parameters.
  void ask_by_parameters(Pending& pending);
  /// How many count for GameSettings::max_requests. When an answer comes is neither reproducible nor recorded, so what
  /// was foreseen counts for a moment, and other hits until their answer takes effect.
  std::size_t counted_requests() const;
  bool is_kept(const Pending& pending) const;  ///< for a hit that has not come
  void apply(Pending& pending);
  void apply_hit(Pending& pending);
  bool apply_due();  ///< whether bodies were swapped
  /// The server has looked at a mesh, and knows the volume of what will break: of walls, where it makes some.
  void weigh(const std::vector<std::size_t>& things, const std::string& answer);
  void scale_mass(std::size_t thing, double factor);
  bool adopt(Requests::iterator pending);  ///< the same
  void play_recorded();                    ///< what was recorded before this step
  void play_answer(const RecordedEvent& event);
  void record(const RecordedEvent& event);
  void take_events();
  /// From where it is seen, before a step that decides by it. A replay has to know when it plays that.
  void record_eye(std::uint64_t step);
  void note_failure(Pending& pending, const std::string& what);
  /// pending_.end() for those of a game before this one.
  Requests::iterator request_of(protocol::Ticket ticket);
  bool replay_is_ready() const;
  bool is_recorded() const { return settings_.recorder || settings_.history; }
  std::size_t thing_of(world::ObjectId object) const;

  scenes::Scene scene_;
  protocol::Client& client_;
  GameSettings settings_;
  world::World world_;
  Decoder decoder_;
  std::vector<Thing> things_;
  Requests pending_;
  std::vector<Waiting> waiting_;
  glm::dvec3 eye_;
  std::optional<glm::dvec3> recorded_eye_;
  std::vector<world::Swap> swaps_;
  GameFigures figures_;
  std::shared_ptr<const std::string> last_glb_;
  std::uint64_t asked_ = 0;
  /// Meshes that the server has not answered to yet, and what is made of them.
  std::map<protocol::Ticket, std::vector<std::size_t>> storing_;
  /// The same, and what the server said of them while a recording was played, which knows better: for the time after it.
  std::vector<std::pair<std::vector<std::size_t>, std::string>> to_weigh_;
  std::set<std::size_t> weighed_;  ///< things
  std::size_t next_throw_ = 0, next_blast_ = 0, meshes_stored_ = 0, next_recorded_ = 0;
  std::string patterns_;
  double owed_ = 0;  ///< seconds not yet simulated
};

}  // namespace fracture::game
