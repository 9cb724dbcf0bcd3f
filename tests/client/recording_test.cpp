#include "client/game/recording.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "tests/client/recorded_game.hpp"

namespace fracture::game {
namespace {

using test::FakeRequest;
using test::FakeServer;

TEST_F(Recordings, PlayedAgainGiveTheSameBits) {
  const std::string path = folder_ / "game.jsonl";
  const std::uint64_t fingerprint = play(path);
  const Expected<Recording> recording = read_recording(path);
  ASSERT_TRUE(recording) << recording.error().detail;
  EXPECT_EQ(recording->header["scene"], "boxes");
  EXPECT_GT(recording->hashes.size(), 200u);
  EXPECT_EQ(recording->hashes.back(), fingerprint);
  // A server with different response times.
  FakeServer slow([this](const FakeRequest& request) {
    // pause: the answers arrive in other steps than before
    std::this_thread::sleep_for(std::chrono::milliseconds(request.number % 2 == 0 ? 30 : 1));
    return answer(request);
  });
  protocol::Client client(test::settings_for(slow));
  Game game(scene(), client, replaying(*recording));
  play_again(game);
  EXPECT_FALSE(game.figures().diverged) << *game.figures().diverged;
  EXPECT_EQ(game.world().fingerprint(), fingerprint);
}

TEST_F(Recordings, TheFirstStepThatDiffersIsNamed) {
  const std::string path = folder_ / "game.jsonl";
  play(path);
  Expected<Recording> recording = read_recording(path);
  ASSERT_TRUE(recording) << recording.error().detail;
  std::uint64_t thrown = 0;
  for (RecordedEvent& event : recording->events)
    if (event.kind == RecordedEvent::Kind::kThrow) {
      event.velocity.x += 1e-9;
      thrown = event.step;
    }
  ASSERT_GT(thrown, 0u);
  FakeServer server([this](const FakeRequest& request) { return answer(request); });
  protocol::Client client(test::settings_for(server));
  Game game(scene(), client, replaying(*recording));
  play_again(game);
  ASSERT_TRUE(game.figures().diverged);
  EXPECT_EQ(*game.figures().diverged, thrown);
}

TEST_F(Recordings, WhatIsNoRecordingIsRefusedWithItsLine) {
  const auto detail = [&](const std::string& text) {
    const std::string path = folder_.write("bad.jsonl", text);
    const Expected<Recording> recording = read_recording(path);
    return recording ? std::string() : recording.error().detail;
  };
  const std::string header = R"({"format": "fracture-game-1"})";
  EXPECT_NE(detail("").find("empty"), std::string::npos);
  EXPECT_NE(detail("{}").find("line 1"), std::string::npos);
  EXPECT_NE(detail(R"({"format": "other"})").find("its format is"), std::string::npos);
  EXPECT_NE(detail(R"({"format": "fracture-game-1", "rules": 99})").find("another version, with rules 99"),
            std::string::npos);
  EXPECT_NE(detail(header + "\n{\"step\": 0, \"hash\": \"xyz\"}\n").find("hexadecimal"), std::string::npos);
  EXPECT_NE(detail(header + "\n{\"step\": 0, \"throw\": [[1, 2], [0, 0, 0]]}\n").find("line 2"),
            std::string::npos);
  EXPECT_NE(detail(header + "\n{\"step\": 1, \"hash\": \"00\"}\n").find("must be the next one"),
            std::string::npos);
  EXPECT_NE(detail(header + "\n{\"step\": 0, \"ha\n{\"step\": 0, \"hash\": \"00\"}\n").find("line 2"),
            std::string::npos);
  EXPECT_NE(detail(header.substr(0, 9)).find("line 1"), std::string::npos);
  EXPECT_NE(read_recording(folder_.path).error().detail.find("is a folder"), std::string::npos);
  EXPECT_NE(read_recording(folder_ / "nowhere").error().detail.find("nowhere"), std::string::npos);
}

TEST_F(Recordings, OfAFullDiskArePlayedUpToTheLastWholeLine) {
  const std::string whole = R"({"format": "fracture-game-1"})"
                            "\n{\"step\": 0, \"hash\": \"1f\"}\n";
  for (const std::string& rest :
       {std::string(), std::string("{\"step\":1,"), std::string("{\"step\": 1, \"ha")}) {
    const Expected<Recording> recording = read_recording(folder_.write("cut.jsonl", whole + rest));
    ASSERT_TRUE(recording) << recording.error().detail;
    EXPECT_EQ(recording->hashes, (std::vector<std::uint64_t>{0x1f}));
    EXPECT_EQ(recording->cut_off, !rest.empty());
  }
}

}  // namespace
}  // namespace fracture::game
