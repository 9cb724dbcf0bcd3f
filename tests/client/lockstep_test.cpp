// Two games that stay identical: the same bits from the actions of both players, and a stated reason whenever
// the link ends.
#include "client/game/lockstep.hpp"

#include <gtest/gtest.h>

#include "tests/client/recorded_game.hpp"

namespace fracture::game {
namespace {

using test::FakeRequest;
using test::FakeServer;

constexpr unsigned kAnswerSteps = 6;

class Lockstepped : public Recordings {
 protected:
  /// A player with a client, a game and a seat.
  struct Player {
    Player(const FakeServer& server, scenes::Scene scene, PeerLink& link, Lockstep::Seat seat,
           const nlohmann::json& header, std::chrono::milliseconds patience = test::kPatience)
        : client(test::settings_for(server)),
          game(std::move(scene), client, settings()),
          play(game, link, seat, header, nullptr, patience) {}
    GameSettings settings() const {
      GameSettings s;
      s.fixed_latency = kAnswerSteps;
      s.history = history;
      return s;
    }
    std::uint64_t steps() const { return game.world().steps(); }
    const std::vector<std::uint64_t>& hashes() {
      recording = history->until(history->steps());
      return recording.hashes;
    }
    std::shared_ptr<History> history = std::make_shared<History>(nlohmann::json::object());
    Recording recording;
    protocol::Client client;
    Game game;
    Lockstep play;
  };

  static nlohmann::json header(std::uint64_t seed = 1) {
    return lockstep_header({{"scene", "boxes"}, {"seed", seed}}, kAnswerSteps);
  }
  static std::unique_ptr<PeerLink> invite(PeerSettings settings = {}) {
    auto link = PeerLink::invite("127.0.0.1", 0, settings);
    if (!link) throw std::runtime_error(link.error().detail);
    return std::move(*link);
  }
  /// Plays a step if it may be played.
  static bool step(Player& player) {
    if (!player.play.ready()) return false;
    player.play.step();
    return true;
  }
  static std::string words_of(PeerLink& link) {
    std::string why;
    test::require_eventually(test::kPatience, "the link to end", [&] {
      link.poll();
      if (const auto ended = link.ended()) why = *ended;
      return !why.empty();
    });
    return why;
  }
  static std::string words_of(Player& player) {
    test::require_eventually(test::kPatience, "the game to end", [&] {
      step(player);
      return player.play.trouble().has_value();
    });
    return *player.play.trouble();
  }

  FakeServer server_{[this](const FakeRequest& request) { return answer(request); }};
};

TEST_F(Lockstepped, BothHaveTheSameBitsFromWhatBothDo) {
  const auto host_link = invite(), guest_link = PeerLink::join("127.0.0.1", host_link->port());
  Player host(server_, scene(), *host_link, Lockstep::Seat::kHost, header()),
      guest(server_, scene(), *guest_link, Lockstep::Seat::kGuest, header());
  constexpr std::uint64_t kSteps = 240;
  std::uint64_t farthest = 0;
  const auto act = [&](Player& player, bool is_host) {
    if (player.steps() == 60)  // both at once
      player.play.throw_ball({is_host ? 0.5 : 6.5, 0.5, 4}, {0.1, 1.0 / 3, -20});
    if (is_host && player.steps() == 100) player.play.explode({{3, 0.3, 1}, 8000, 5});
    if (!is_host && player.steps() == 110) player.play.throw_ball({9.5, 0.5, 5}, {0, 1, -12}, {0.4, 7800});
  };
  test::require_eventually(test::kPatience, "both games to be played", [&] {
    for (Player* player : {&host, &guest}) {
      const std::uint64_t before = player->steps();
      if (before < kSteps && step(*player)) act(*player, player == &host);
    }
    farthest = std::max(
        farthest, host.steps() > guest.steps() ? host.steps() - guest.steps() : guest.steps() - host.steps());
    if (host.play.trouble()) throw std::runtime_error(*host.play.trouble());
    if (guest.play.trouble()) throw std::runtime_error(*guest.play.trouble());
    return host.steps() == kSteps && guest.steps() == kSteps && host.play.level() && guest.play.level();
  });
  EXPECT_EQ(host.hashes(), guest.hashes());
  EXPECT_EQ(host.hashes().size(), kSteps);
  EXPECT_LE(farthest, kLockstepDelay);
  EXPECT_GE(host.game.figures().swaps, 3u);
  // The actions of both players take effect a tenth of a second later, the host's first.
  std::vector<std::uint64_t> done;
  for (const RecordedEvent& event : host.recording.events)
    if (event.kind == RecordedEvent::Kind::kThrow || event.kind == RecordedEvent::Kind::kExplode)
      done.push_back(event.step);
  EXPECT_EQ(done, (std::vector<std::uint64_t>{72, 72, 112, 122}));
  for (Player* player : {&host, &guest}) {
    std::vector<double> thrown;
    for (const RecordedEvent& event : player->recording.events)
      if (event.kind == RecordedEvent::Kind::kThrow) thrown.push_back(event.from.x);
    EXPECT_EQ(thrown, (std::vector<double>{0.5, 6.5, 9.5}));
  }
}

TEST_F(Lockstepped, TheFirstStepThatIsNotTheSameIsNamedOnBothSides) {
  const auto host_link = invite(), guest_link = PeerLink::join("127.0.0.1", host_link->port());
  scenes::Scene other = scene();
  other.ball_radius *= 1.5;  // no digest in these headers reveals this
  Player host(server_, scene(), *host_link, Lockstep::Seat::kHost, header()),
      guest(server_, other, *guest_link, Lockstep::Seat::kGuest, header());
  bool thrown = false;
  test::require_eventually(test::kPatience, "the games to part", [&] {
    step(guest);
    step(host);
    if (!thrown && host.steps() == 10) {
      host.play.throw_ball({0.5, 0.5, 1.2}, {0, 0, -20});
      thrown = true;
    }
    return host.play.trouble() && guest.play.trouble();
  });
  // Balls of two sizes fly alike until one of them hits something.
  const std::optional<std::uint64_t> step =
      host.play.diverged() ? host.play.diverged() : guest.play.diverged();
  ASSERT_TRUE(step);
  const std::vector<std::uint64_t>&mine = host.hashes(), &theirs = guest.hashes();
  ASSERT_LT(*step, std::min(mine.size(), theirs.size()));
  EXPECT_NE(mine[*step], theirs[*step]);
  for (std::uint64_t k = 0; k < *step; ++k) ASSERT_EQ(mine[k], theirs[k]) << k;
  EXPECT_GE(*step, 10 + kLockstepDelay);
  for (Player* player : {&host, &guest})
    EXPECT_NE(player->play.trouble()->find("Step " + std::to_string(*step)), std::string::npos)
        << *player->play.trouble();
}

TEST_F(Lockstepped, AnotherSeedIsRefusedBeforeTheFirstStep) {
  const auto host_link = invite(), guest_link = PeerLink::join("127.0.0.1", host_link->port());
  Player host(server_, scene(), *host_link, Lockstep::Seat::kHost, header(1)),
      guest(server_, scene(), *guest_link, Lockstep::Seat::kGuest, header(2));
  for (Player* player : {&host, &guest}) {
    const std::string words = words_of(*player);
    EXPECT_NE(words.find("seed: "), std::string::npos) << words;
    EXPECT_EQ(player->steps(), 0u);
  }
}

TEST_F(Lockstepped, OtherVersionsAndWhatIsNoHeaderAreRefusedInWords) {
  nlohmann::json rules = header(), format = header(), delay = header();
  rules["rules"] = 99;
  format["format"] = "fracture-lockstep-9";
  delay["delay"] = 0;
  const auto detail = [](const std::string& line) {
    const auto read = read_lockstep_header(line);
    return read ? std::string() : read.error().detail;
  };
  EXPECT_EQ(detail(header().dump()), "");
  EXPECT_NE(detail(rules.dump()).find("rules 99"), std::string::npos);
  EXPECT_NE(detail(format.dump()).find("fracture-lockstep-9"), std::string::npos);
  EXPECT_NE(detail(delay.dump()).find("delay"), std::string::npos);
  EXPECT_NE(detail("hello").find("not the header"), std::string::npos);
  EXPECT_NE(detail(R"({"refused": "No."})").find("refused: No."), std::string::npos);
  // As a first line: the other player is told why.
  const auto host_link = invite(), guest_link = PeerLink::join("127.0.0.1", host_link->port());
  Player host(server_, scene(), *host_link, Lockstep::Seat::kHost, header());
  guest_link->send(rules.dump());
  EXPECT_NE(words_of(host).find("rules 99"), std::string::npos);
  std::string last;
  test::require_eventually(test::kPatience, "the refusal", [&] {
    for (const std::string& line : guest_link->poll()) last = line;
    return last.find("refused") != std::string::npos;
  });
  EXPECT_NE(last.find("rules 99"), std::string::npos);
}

TEST_F(Lockstepped, LinesThatCannotBeUsedEndTheGameInWords) {
  const std::string event = R"({"step": 12, "throw": [[0, 1, 2], [0, 0, 0]]})";
  for (const auto& [line, words] : std::vector<std::pair<std::string, std::string>>{
           {"{\"step\": 12, \"thr", "is invalid"},
           {R"({"step": 13, "throw": [[0, 1, 2], [0, 0, 0]]})", "expected step 12"},
           {R"({"step": 1, "hash": "00"})", "expected step 0"},
           {R"({"step": 0, "hash": "no"})", "hexadecimal"},
           {R"({"step": 12, "adopt": 1})", "a player can only send throws and explosions"},
           {R"({"step": 12, "explode": [0, 1, 2], "impulse": -1, "radius": 1})",
            "impulse must be more than 0"},
           {std::string(70'000, 'x'), "more than 65536 bytes"}}) {
    const auto host_link = invite(), guest_link = PeerLink::join("127.0.0.1", host_link->port());
    Player host(server_, scene(), *host_link, Lockstep::Seat::kHost, header());
    guest_link->send(header().dump());
    guest_link->send(event);
    guest_link->send(line);
    const std::string said = words_of(host);
    EXPECT_NE(said.find(words), std::string::npos) << said;
  }
}

TEST_F(Lockstepped, WhoLeavesIsMissed) {
  const auto host_link = invite();
  auto guest_link = PeerLink::join("127.0.0.1", host_link->port());
  Player host(server_, scene(), *host_link, Lockstep::Seat::kHost, header());
  {
    Player guest(server_, scene(), *guest_link, Lockstep::Seat::kGuest, header());
    test::require_eventually(test::kPatience, "some steps", [&] {
      step(host);
      step(guest);
      return host.steps() > 30 && guest.steps() > 30;
    });
  }
  guest_link.reset();
  EXPECT_EQ(words_of(host), "The other player has left the game.");
}

TEST_F(Lockstepped, WhoIsNoPlayerDoesNotEndAnInvitation) {
  PeerSettings impatient, mute;
  impatient.strange_silence = std::chrono::milliseconds(50);
  mute.beat = std::chrono::hours(1);
  const auto host_link = invite(impatient);
  const std::string first = header().dump();
  host_link->send(first);
  const auto is_greeted_and_lost = [&](PeerLink& stranger) {
    std::vector<std::string> heard;
    test::require_eventually(test::kPatience, "the stranger to be left", [&] {
      for (std::string& line : stranger.poll()) heard.push_back(std::move(line));
      return stranger.ended().has_value();
    });
    EXPECT_EQ(heard, (std::vector<std::string>{first}));
  };
  for (const std::string& said : {std::string("GET / HTTP/1.1\r"), std::string(70'000, 'x'), std::string()}) {
    const auto stranger = PeerLink::join("127.0.0.1", host_link->port(), mute);
    if (!said.empty()) stranger->send(said);
    is_greeted_and_lost(*stranger);
  }
  PeerLink::join("127.0.0.1", host_link->port());  // it leaves at once
  const auto guest_link = PeerLink::join("127.0.0.1", host_link->port());
  guest_link->send(first);
  std::string answered, greeted;
  test::require_eventually(test::kPatience, "the two players to hear one another", [&] {
    for (const std::string& line : host_link->poll()) answered = line;
    for (const std::string& line : guest_link->poll()) greeted = line;
    return !answered.empty() && !greeted.empty();
  });
  EXPECT_EQ(answered, first);
  EXPECT_EQ(greeted, first);
  EXPECT_FALSE(host_link->ended());
}

TEST_F(Lockstepped, WhoIsThereButDoesNotGoOnIsLeftAndToldSo) {
  const auto host_link = invite(), guest_link = PeerLink::join("127.0.0.1", host_link->port());
  Player host(server_, scene(), *host_link, Lockstep::Seat::kHost, header(), std::chrono::milliseconds(50)),
      guest(server_, scene(), *guest_link, Lockstep::Seat::kGuest, header());
  test::require_eventually(test::kPatience, "both to have met", [&] {
    guest.play.ready();
    return step(host);
  });
  EXPECT_NE(words_of(host).find("has not played a step"), std::string::npos);
  EXPECT_EQ(host.steps(), kLockstepDelay);  // as far as it may go without the other player
  EXPECT_EQ(words_of(guest), "The other player refused: " + *host.play.trouble());
}

TEST_F(Lockstepped, WhoGivesUpSaysWhy) {
  const auto host_link = invite(), guest_link = PeerLink::join("127.0.0.1", host_link->port());
  Player host(server_, scene(), *host_link, Lockstep::Seat::kHost, header()),
      guest(server_, scene(), *guest_link, Lockstep::Seat::kGuest, header());
  test::require_eventually(test::kPatience, "some steps", [&] {
    step(guest);
    return step(host) && host.steps() > 5;
  });
  host.play.leave("No server has answered.");
  EXPECT_EQ(words_of(guest), "The other player refused: No server has answered.");
}

TEST_F(Lockstepped, WhoIsSilentIsGone) {
  PeerSettings impatient, mute;
  impatient.silence = std::chrono::milliseconds(300);
  mute.beat = std::chrono::hours(1);
  const auto host_link = invite(impatient), guest_link = PeerLink::join("127.0.0.1", host_link->port(), mute);
  guest_link->send("{hello}");
  EXPECT_EQ(words_of(*host_link), "The other player sent nothing for 0.3 s.");
}

TEST_F(Lockstepped, ASignOfLifeIsNoLine) {
  PeerSettings lively;
  lively.beat = std::chrono::milliseconds(1);
  const auto host_link = invite(), guest_link = PeerLink::join("127.0.0.1", host_link->port(), lively);
  guest_link->send("{first}");
  guest_link->send("{second}");
  std::vector<std::string> lines;
  test::require_eventually(test::kPatience, "both lines", [&] {
    for (std::string& line : host_link->poll()) lines.push_back(std::move(line));
    return lines.size() >= 2;
  });
  EXPECT_EQ(lines, (std::vector<std::string>{"{first}", "{second}"}));
}

TEST_F(Lockstepped, WhatNobodyPollsIsNotReadWithoutEnd) {
  PeerSettings few;
  few.most_waiting = 10;
  few.silence = std::chrono::milliseconds(300);
  const auto host_link = invite(few), guest_link = PeerLink::join("127.0.0.1", host_link->port());
  constexpr int kLines = 1000;
  for (int k = 0; k < kLines; ++k) guest_link->send('{' + std::to_string(k));
  std::size_t most = 0;
  int next = 0;
  test::require_eventually(test::kPatience, "all lines", [&] {
    const std::vector<std::string> lines = host_link->poll();
    most = std::max(most, lines.size());
    for (const std::string& line : lines) EXPECT_EQ(line, '{' + std::to_string(next++));
    return next == kLines;
  });
  EXPECT_LE(most, few.most_waiting);
  EXPECT_FALSE(host_link->ended());
}

TEST_F(Lockstepped, WhoWaitsForNobodyStopsWaiting) {
  PeerSettings impatient;
  impatient.patience = std::chrono::milliseconds(200);
  std::uint16_t port;
  {
    const auto host_link = invite(impatient);
    port = host_link->port();
    EXPECT_EQ(words_of(*host_link), "No player joined within 0.2 s.");
  }
  const auto guest_link = PeerLink::join("127.0.0.1", port, impatient);
  const std::string words = words_of(*guest_link);
  EXPECT_NE(words.find("No player answered at 127.0.0.1:" + std::to_string(port)), std::string::npos)
      << words;
  const auto taken = PeerLink::invite("203.0.113.1", 1);  // a documentation address, not this machine
  ASSERT_FALSE(taken);
  EXPECT_NE(taken.error().detail.find("203.0.113.1:1"), std::string::npos);
}

}  // namespace
}  // namespace fracture::game
