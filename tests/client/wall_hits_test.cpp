// A wall that is hit twice, with a real server. Both places get finer fragments, and the answer to the second
// hit contains only its changes.
#include <gtest/gtest.h>

#include <algorithm>

#include "client/game/game.hpp"
#include "client/scenes/scene.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::game {
namespace {

class WallHits : public testing::Test {
 protected:
  static void step(Game& game) {
    test::require_eventually(test::kPatience, "the answers of the step", [&] { return game.ready(); });
    game.step();
  }
  /// Slow enough that the first ball does not break the whole wall.
  static void throw_at(Game& game, double x) { game.throw_ball({x, 1.3, 6}, {0, 1.8, -12}); }
  /// Number of fragments whose centres are within half a metre of a place on the wall.
  static std::size_t fragments_near(const Game& game, double x) {
    const Thing& thing = game.things()[0];
    std::vector<world::FragmentState> states;
    game.world().fragment_states(thing.id, states);
    const world::FragmentSet& set = world::fragments_of(*thing.fragments->fragments);
    const glm::dvec3 place = glm::dvec3(x, 1.3, 0.14) - game.scene().objects[0].pose.position;
    std::size_t count = 0;
    for (std::size_t k = 0; k < states.size(); ++k)
      count += states[k].present && glm::distance(set.fragments[k].mass.center, place) < 0.5;
    return count;
  }
  struct Played {
    std::size_t before = 0, after = 0;           ///< fragments near the second hit
    std::size_t hit_bytes = 0, whole_bytes = 0;  ///< of the answer to the hit, and of one with all fragments
    std::uint64_t fingerprint = 0;
    GameFigures figures;
    world::Ledger ledger;
  };
  static Played play(const test::ServeProcess& server, const char* material) {
    protocol::Settings connection;
    connection.port = server.port;
    protocol::Client client(connection);
    Expected<scenes::Scene> scene = scenes::make_scene("concrete");
    if (!scene) throw std::runtime_error(scene.error().detail);
    scene->throws.clear();
    scenes::set_material(*scene, material);
    GameSettings settings;
    settings.fixed_latency = 6;
    Game game(std::move(*scene), client, settings);
    Played played;
    throw_at(game, 1.1);
    for (int k = 0; k < 120; ++k) step(game);
    played.before = fragments_near(game, -1);
    throw_at(game, -1);
    for (int k = 0; k < 120 && game.figures().hits == 0; ++k) step(game);
    played.after = fragments_near(game, -1);
    played.hit_bytes = game.things()[0].fragments->glb->size();
    for (int k = 0; k < 120; ++k) step(game);
    played.figures = game.figures();
    played.fingerprint = game.world().fingerprint();
    played.ledger = game.world().ledger();
    const protocol::Ticket whole = client.fracture(game.things()[0].mesh, game.things()[0].parameters);
    test::require_eventually(test::kPatience, "all fragments with the hit", [&] {
      for (const protocol::Answer& answer : client.poll())
        if (answer.ticket == whole) played.whole_bytes = answer.ok() ? answer.body.size() : 1;
      return played.whole_bytes > 0;
    });
    return played;
  }
};

TEST_F(WallHits, ASecondOneMakesMorePiecesAtItsPlace) {
  test::ServeProcess server({"--realtime-deadline", "60"});  // independent of how fast this machine is
  for (const char* material : {"concrete", "stone"}) {
    SCOPED_TRACE(material);
    const Played played = play(server, material);
    EXPECT_EQ(played.figures.hits, 1u);
    EXPECT_EQ(played.figures.too_late, 0u);
    EXPECT_EQ(played.figures.failures, 0u) << played.figures.last_trouble;
    EXPECT_GT(played.after, 2 * played.before);
    EXPECT_LT(played.hit_bytes, 0.9 * static_cast<double>(played.whole_bytes));
    EXPECT_LT(played.ledger.worst_gain, 0.01 * played.ledger.brought);
  }
}

TEST_F(WallHits, AreTheSameWhateverTheServerKnows) {
  test::ServeProcess server({"--realtime-deadline", "60"}), other({"--realtime-deadline", "60"});
  const Played first = play(server, "concrete");
  EXPECT_EQ(first.figures.hits, 1u);
  EXPECT_EQ(play(server, "concrete").fingerprint, first.fingerprint) << "now it has both answers";
  EXPECT_EQ(play(other, "concrete").fingerprint, first.fingerprint);
}

}  // namespace
}  // namespace fracture::game
