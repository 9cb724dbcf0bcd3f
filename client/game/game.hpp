// The game's rules: when requests are sent, and how the answers change the world. No window, no OpenGL.
//
// In real time nothing waits. advance() runs the steps that are due, polls, and applies the answer that was
// decoded by the previous frame (one answer per frame). coming() shows it to the renderer in time to upload
// it. In a window, a separate thread calls attend() and step() itself (app/simulation.hpp).
//
// With GameSettings::fixed_latency the run is reproducible: an answer is applied a fixed number of steps
// after its request. If the server is slower than that, simulated time pauses until it has answered (ready()
// is false). If the server is faster, the answer is kept. The server's answers depend only on the requests,
// the requests only on the motion before them, and the motion only on the steps. So equal seeds give
// identical runs.
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
  std::optional<unsigned> fixed_latency;  ///< steps until the answer to a request takes effect
  bool anticipate = true;                 ///< sends requests while a ball approaches, not only at the contact
  /// Maximum number of open requests (Game::counted_requests()). Further hits wait, and the most urgent is
  /// next.
  std::size_t max_requests = 8;
  nlohmann::json overrides =
      nlohmann::json::object();  ///< parameters at the start; then Game::set_overrides()
  world::WorldSettings world;
  std::shared_ptr<Recorder> recorder;    ///< records everything; null: no recording
  std::shared_ptr<History> history;      ///< records in memory; null: no recording
  std::shared_ptr<KeptAnswers> answers;  ///< answers to earlier requests; null: everything is requested
  /// The recorded game to replay: until hand_over() it decides when answers take effect.
  std::shared_ptr<const Recording> replay;
};

/// One object of the world as the renderer needs it.
struct Thing {
  world::ObjectId id = 0;
  std::size_t scene_object = 0;  ///< index into Scene::objects; secondary pieces have that of their parent
  std::string mesh;              ///< id of the stored mesh
  std::shared_ptr<const Decoded> fragments;  ///< null while whole
  nlohmann::json parameters;  ///< of the request that created the fragments, and all later hits
  bool secondary = false;
  std::set<world::BallId> hit_by;  ///< balls whose hits on its fragments were requested, once each
};

struct GameFigures {
  std::uint64_t requests = 0, answers = 0, failures = 0, swaps = 0, secondary = 0, held_steps = 0;
  std::uint64_t hits = 0;      ///< further hits that replaced existing fragments by finer ones …
  std::uint64_t too_late = 0;  ///< … and those whose fragments had already come loose
  std::string last_trouble;
  std::string last_break;            ///< for people: what broke into how many pieces, and how long it took
  double worst_momentum_error = 0;   ///< largest relative error of swaps without anchors, linear and angular
  std::vector<world::Break> breaks;  ///< of things whose fragments are not requested at level start
  std::optional<std::uint64_t> diverged;  ///< the first step after which a replay differed from the recording
};

class Game {
 public:
  /// Stores the meshes and sends the requests that the level needs at its start. `client` outlives the game.
  Game(scenes::Scene scene, protocol::Client& client, GameSettings settings);
  ~Game();

  /// Reproducible runs and replays: whether the next step has everything it needs. Polls; never blocks.
  bool ready();
  /// One step of WorldSettings::step. In reproducible runs, only if ready().
  void step();
  /// Real time, before each step and occasionally while paused: applies one answer, polls, and sends
  /// requests. Returns whether bodies were swapped.
  bool attend();
  /// Real time: as many steps as fit into `seconds` (at most 6; the rest is dropped), or none while paused.
  void advance(double seconds, bool running);

  world::BallId throw_ball(const glm::dvec3& from, const glm::dvec3& velocity, const scenes::Ball& ball = {});
  void explode(const world::Blast& blast);

  /// Everything visible and audible since the last call. Empty without WorldSettings::max_witnessed.
  world::Witnessed take_witnessed() { return world_.take_witnessed(); }
  /// The server's name for the material; empty if the object's request has none.
  std::string material_of(world::ObjectId object) const;

  const scenes::Scene& scene() const { return scene_; }
  const std::vector<Thing>& things() const { return things_; }
  /// A thing's fragments that have arrived and take effect in a coming frame (for pieces: the parent's).
  struct Coming {
    std::size_t thing;
    std::size_t scene_object;  ///< of the thing
    std::shared_ptr<const Decoded> fragments;
  };
  std::vector<Coming> coming() const;
  const world::World& world() const { return world_; }
  const GameFigures& figures() const { return figures_; }
  const std::vector<world::Swap>& swaps() const { return swaps_; }  ///< all swaps since the start
  const GameSettings& settings() const { return settings_; }
  std::size_t open_requests() const;  ///< without a usable answer yet
  std::size_t kept_answers() const;   ///< for predicted hits that have not happened
  std::size_t waiting_requests() const { return waiting_.size(); }  ///< for an open request to end
  /// The viewpoint: of two equal hits the nearer one is requested first. Initially the scene's.
  void set_eye(const glm::dvec3& eye) { eye_ = eye; }
  void set_overrides(nlohmann::json overrides);
  /// Whether all steps of the recording have been played.
  bool replayed() const { return settings_.replay && world_.steps() >= settings_.replay->hashes.size(); }
  /// Ends the replay: from here on the game continues normally, with the answers that are still awaited.
  void hand_over();
  /// Throws the scene's own balls up to a time in seconds. Reproducible runs do so in step().
  void throw_scripted(double until);
  /// The last complete answer, for saving; null before the first.
  std::shared_ptr<const std::string> last_glb() const { return last_glb_; }
  std::size_t meshes_stored() const { return meshes_stored_; }
  /// The answer to Client::patterns(), which the user of this class requests; empty before it arrives.
  const std::string& patterns() const { return patterns_; }

 private:
  struct Pending {
    protocol::Ticket ticket = 0;  ///< 0: the answer was already kept
    std::size_t thing = 0;
    std::optional<std::uint32_t> fragment;  ///< secondary
    nlohmann::json wanted;                  ///< the complete request
    nlohmann::json parameters;              ///< of all fragments once the answer has taken effect
    /// For a further hit: the answer that it changes. If the server has forgotten that answer, `wanted` is
    /// requested instead.
    std::shared_ptr<const Decoded> before;
    bool by_name = false;
    std::string location;   ///< of the answer
    std::uint64_t due = 0;  ///< step; only with fixed_latency
    std::shared_ptr<const Decoded> decoded;
    double milliseconds = 0;     ///< from the request to the answer
    std::uint64_t asked_at = 0;  ///< step
    bool ahead = false;          ///< requested before a hit: waits until World::expects_hit() is true
    bool failed = false;
    bool finished() const { return failed || decoded; }
  };

  /// A hit for which a request is to be sent.
  struct Waiting {
    std::size_t thing = 0;
    std::optional<std::uint32_t> fragment{};
    world::Impact impact{};
    double urgency = 0;
    bool ahead = false;
    bool again = false;  ///< a further hit on its fragments
  };
  using Requests = std::map<std::uint64_t, Pending>;  ///< by number, from 1, in request order

  void poll();
  void want(const Waiting& hit);  ///< keeps the more urgent of two hits on the same thing
  void ask_most_urgent();         ///< sends as many as may be open
  void ask(const Waiting& hit);
  /// Whether a further hit would give finer fragments and has not been requested yet.
  bool wants_again(const Thing& thing, const world::Event& event) const;
  /// The server has forgotten the answer in the request: requests the same result by its parameters.
  void ask_by_parameters(Pending& pending);
  /// Number of requests that count towards GameSettings::max_requests. Arrival times are neither reproducible
  /// nor recorded. So predicted hits count for a moment, and other hits until their answer takes effect.
  std::size_t counted_requests() const;
  bool is_kept(const Pending& pending) const;  ///< for a hit that has not happened
  void apply(Pending& pending);
  void apply_hit(Pending& pending);
  bool apply_due();  ///< returns whether bodies were swapped
  /// Corrects masses by the server's report on a mesh. The mass is that of the volume that will break: the
  /// walls' volume, if there are walls.
  void weigh(const std::vector<std::size_t>& things, const std::string& answer);
  void scale_mass(std::size_t thing, double factor);
  bool adopt(Requests::iterator pending);  ///< returns whether bodies were swapped
  void play_recorded();                    ///< plays the recorded events before this step
  void play_answer(const RecordedEvent& event);
  void record(const RecordedEvent& event);
  void take_events();
  /// Records the viewpoint before a step that depends on it, because a replay needs it.
  void record_eye(std::uint64_t step);
  void note_failure(Pending& pending, const std::string& what);
  /// pending_.end() for requests from an earlier game.
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
  /// Meshes for which the server has not answered yet, and the things made of them.
  std::map<protocol::Ticket, std::vector<std::size_t>> storing_;
  /// Reports that arrived during a replay, with their things. They are used after it, because the recording
  /// takes precedence.
  std::vector<std::pair<std::vector<std::size_t>, std::string>> to_weigh_;
  std::set<std::size_t> weighed_;  ///< things
  std::size_t next_throw_ = 0, next_blast_ = 0, meshes_stored_ = 0, next_recorded_ = 0;
  std::string patterns_;
  double owed_ = 0;  ///< seconds still to be simulated
};

}  // namespace fracture::game
