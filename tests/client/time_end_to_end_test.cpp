// A continued game and the player's options in it, against a real server.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "client/game/recording.hpp"
#include "tests/client/headless_run.hpp"
#include "tests/server/support/child_process.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::app {
namespace {

using nlohmann::json;

TEST(TimeEndToEnd, AGameThatIsGoneOnWithIsTheOneThatWasNeverInterrupted) {
  test::ServeProcess server;
  test::TemporaryFolder folder;
  Options whole = options_for(server, "panes", 2.8);
  whole.log = folder / "whole.jsonl";
  const json never_interrupted = run(whole);
  EXPECT_GE(never_interrupted["game"]["swaps"].get<int>(), 2);
  for (const double stopped : {0.5, 2.3}) {  // after the first ball was thrown, and after the second
    Options first = options_for(server, "panes", stopped);
    first.log = folder / "first.jsonl";
    run(first);
    Options second = options_for(server, "monkey", 2.8);  // the scene is in the file
    second.continue_from = first.log;
    second.log = folder / "second.jsonl";
    const json gone_on = run(second);
    EXPECT_EQ(gone_on["fingerprint"], never_interrupted["fingerprint"]) << stopped;
    EXPECT_EQ(gone_on["swaps"], never_interrupted["swaps"]) << stopped;
    EXPECT_EQ(test::read_file(second.log), test::read_file(whole.log)) << stopped;
  }
  // Continued in real time, its own recording is also complete.
  Options live = options_for(server, "panes", 2.6);
  live.fixed_step = false;
  live.continue_from = folder / "first.jsonl";
  live.log = folder / "live.jsonl";
  const json lived = run(live);
  Options again = options_for(server, "panes", 1);
  again.replay = live.log;
  const json replayed = run(again);
  EXPECT_TRUE(replayed["game"]["diverged"].is_null()) << replayed["game"]["diverged"];
  EXPECT_EQ(replayed["fingerprint"], lived["fingerprint"]);
}

TEST(TimeEndToEnd, RecordingsOfOtherGamesAreRefusedInWords) {
  test::ServeProcess server;
  test::TemporaryFolder folder;
  Options options = options_for(server, "panes", 0.2);
  options.requests = false;
  options.log = folder / "game.jsonl";
  run(options);
  const std::string text = test::read_file(options.log);
  const auto detail = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    const std::size_t at = changed.find(from);
    if (at == std::string::npos) return "there is no " + from;
    changed.replace(at, from.size(), to);
    Options resumed = options_for(server, "panes", 0.4);
    resumed.continue_from = folder.write("changed.jsonl", changed);
    const Expected<json> summary = run_headless(resumed);
    return summary ? std::string() : summary.error().detail;
  };
  const std::string rules = "\"rules\":" + std::to_string(game::kRules);
  EXPECT_EQ(detail(rules, rules), "");
  EXPECT_NE(detail(rules, "\"rules\":77").find("another version, with rules 77"), std::string::npos);
  EXPECT_NE(detail("\"scene\":\"panes\"", "\"scene\":\"shop\"").find("scene 'shop' differs"),
            std::string::npos);
  EXPECT_NE(detail("\"scene\":\"panes\"", "\"scene\":\"castle\"").find("no scene 'castle'"),
            std::string::npos);
  const std::size_t hash = text.find("\"hash\":\"") + 8;
  const std::string first = text.substr(hash, 16);
  EXPECT_NE(detail(first, "0123456789abcdef").find("Step 0 differs from the recording"), std::string::npos);
}

TEST(TimeEndToEnd, AMonkeyBesideWhichSomethingExplodesBreaksAndSoDoesItsRecording) {
  test::ServeProcess server;
  test::TemporaryFolder folder;
  const Expected<scenes::Scene> scene = scenes::make_scene("monkey");
  ASSERT_TRUE(scene);
  Options options = options_for(server, "monkey", 1);
  options.throws = false;
  options.blasts = {{0.1,
                     {scene->objects[0].pose.position + glm::dvec3(0, 0, 1.5), scenes::kBlastImpulse,
                      scenes::kBlastRadius}}};
  options.log = folder / "game.jsonl";
  const json summary = run(options);
  EXPECT_EQ(summary["breaks"]["cause"]["blast"]["count"], 1) << summary["breaks"];
  EXPECT_GT(summary["bodies"]["groups"].get<int>(), 10);
  EXPECT_LT(summary["ledger"]["worst_gain"].get<double>(), 0.01);
  EXPECT_GT(summary["fastest_fragment"].get<double>(), 2);
  EXPECT_LT(summary["fastest_fragment"].get<double>(), 25);
  Options again = options_for(server, "monkey", 1);
  again.replay = options.log;
  const json replayed = run(again);
  EXPECT_TRUE(replayed["game"]["diverged"].is_null()) << replayed["game"]["diverged"];
  EXPECT_EQ(replayed["fingerprint"], summary["fingerprint"]);
}

/// The program, with a player who invites or joins.
struct PlayerProcess {
  PlayerProcess(const test::ServeProcess& server, const test::TemporaryFolder& folder,
                const std::string& name, std::vector<std::string> arguments)
      : output(folder / (name + ".out")), client(program(server, std::move(arguments)), output) {}
  static std::vector<std::string> program(const test::ServeProcess& server,
                                          std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {FRACTURE_CLIENT_PROGRAM, "--headless", "--json", "--port",
                                         std::to_string(server.port)});
    return arguments;
  }
  /// Standard output and standard error: only the summary if nothing went wrong.
  std::string said() const { return test::read_file(output); }
  json summary() const {
    const std::string text = said();
    return json::parse(text.substr(text.find('{')));
  }
  std::string output;
  test::ChildProcess client;
};

TEST(TimeEndToEnd, AServerThatIsNotThereEndsAReproducibleRunInWords) {
  Options options;
  options.server.port = static_cast<std::uint16_t>(test::free_port());
  options.headless = options.fixed_step = true;
  options.longest_absence = std::chrono::milliseconds(100);
  const Expected<json> summary = run_headless(options);
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(summary.error().detail.find("No server has answered at 127.0.0.1:"), std::string::npos)
      << summary.error().detail;
}

TEST(TimeEndToEnd, ARunWhoseRequestsAreAllRefusedIsNoSuccess) {
  test::ServeProcess server;
  test::TemporaryFolder folder;
  PlayerProcess player(server, folder, "player",
                       {"--fixed-step", "--scene", "panes", "--seconds", "1", "--set", "interior=off"});
  EXPECT_EQ(player.client.wait(), 1);
  EXPECT_NE(player.said().find("requests failed; the last error: refused: 'interior' must be"),
            std::string::npos)
      << player.said();
}

TEST(TimeEndToEnd, TwoProcessesPlayOneGame) {
  test::ServeProcess server, other_server;
  test::TemporaryFolder folder;
  const std::string port = std::to_string(test::free_port());
  PlayerProcess host(
      server, folder, "host",
      {"--invite", port, "--scene", "panes", "--seed", "5", "--seconds", "1.5", "--explode", "0.5,1,0.5,1"});
  PlayerProcess guest(other_server, folder, "guest",
                      {"--join", "127.0.0.1:" + port, "--explode", "0.9,-1,0.5,1"});
  EXPECT_EQ(host.client.wait(), 0) << host.said();
  EXPECT_EQ(guest.client.wait(), 0) << guest.said();
  const json a = host.summary(), b = guest.summary();
  EXPECT_EQ(a["fingerprint"], b["fingerprint"]);
  EXPECT_EQ(a["fragments"], b["fragments"]);
  EXPECT_EQ(b["scene"], "panes");
  EXPECT_EQ(a["steps"], 180);
  EXPECT_GE(a["breaks"]["cause"]["blast"]["count"].get<int>(), 2) << a["breaks"];
}

TEST(TimeEndToEnd, APlayerWhoIsKilledIsMissed) {
  test::ServeProcess server;
  test::TemporaryFolder folder;
  const std::string port = std::to_string(test::free_port());
  PlayerProcess host(server, folder, "host",
                     {"--invite", port, "--scene", "panes", "--seconds", "3600", "--no-throws"});
  PlayerProcess guest(server, folder, "guest",
                      {"--join", "127.0.0.1:" + port, "--log", folder / "guest.jsonl"});
  test::require_eventually(test::kPatience, "some steps", [&] {
    return test::read_file(folder / "guest.jsonl").find("\"step\":30,") != std::string::npos;
  });
  guest.client.signal(SIGKILL);
  EXPECT_EQ(guest.client.wait(), 1000 + SIGKILL);
  EXPECT_EQ(host.client.wait(), 1) << host.said();
  EXPECT_NE(host.said().find("The other player has left the game."), std::string::npos) << host.said();
}

}  // namespace
}  // namespace fracture::app
