// Slow, numerous or insatiable clients: only they bear the cost of the resources that they hold and of their
// waits.
#include "common/digest/digest.hpp"
#include "tests/attacks/attack.hpp"
#include "tests/attacks/bodies.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/gzip.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

using std::chrono::milliseconds;

/// Processor seconds that a client may wait for others: a hundred times the cost of a collision here.
constexpr double kLongestWait = 0.5;

TEST(TransportAttack, AnnouncedBodies) {
  Siege siege({"--memory", "2GiB"});
  const auto limit =
      ask(siege.server.port, "GET", "/limits").json().value("max_body_bytes", std::uint64_t{64} << 20);
  // Eight clients announce the largest body and send 17 KiB/s, while twenty collisions arrive with their
  // meshes.
  std::atomic<bool> stop{false};
  std::vector<std::thread> slow;
  std::atomic<int> sending{0};
  for (int k = 0; k < 8; ++k)
    slow.emplace_back([&, from = "127.0.1." + std::to_string(k + 1)] {
      while (!stop) {
        try {
          RawClient client(siege.server.port, from);
          bool open = client.send("POST /fracture HTTP/1.1\r\nHost: localhost\r\n" + kObj +
                                  "Content-Length: " + std::to_string(limit) + "\r\n\r\n");
          ++sending;
          while (open && !stop) {
            open = client.send(std::string(1741, '#'));
            // pause: 17 KiB/s are the attack
            std::this_thread::sleep_for(milliseconds(100));
          }
          --sending;
          client.reset();
        } catch (const std::runtime_error&) {
          // pause: a client that was cut off returns, but not at once
          std::this_thread::sleep_for(milliseconds(10));
        }
      }
    });
  EXPECT_TRUE(eventually(kPatience, "all of them to send", [&] { return sending == 8; }));
  std::this_thread::sleep_for(milliseconds(300));  // pause: by then their bytes have arrived
  int posted = 0;
  for (int seed = 0; seed < 20; ++seed)
    posted += ask(siege.server.port, "POST", "/fracture?sites=4&seed=" + std::to_string(seed),
                  kObj + "Priority: u=0\r\n", kCube)
                  .status == 200;
  const int upload =
      ask(siege.server.port, "POST", "/meshes", kObj, kCube + std::string(1u << 20, '#')).status;
  stop = true;
  for (std::thread& thread : slow) thread.join();
  EXPECT_EQ(posted, 20);
  EXPECT_TRUE(upload == 200 || upload == 201) << upload << ": an upload of 1 MiB by somebody else";
  siege.judge("AnnouncedBodies", "20 of 20 collision-time posts get 503", Siege::Refusals::kNone,
              std::to_string(posted) + " of 20 posts served, an upload of 1 MiB: " + std::to_string(upload));
}

TEST(TransportAttack, BodiesThatUnfold) {
  Siege siege({"--memory", "4GiB", "--max-decoded", "128MiB"});
  static const std::string body = gzip(std::string(60u << 20, '#'));
  siege.attack(30, full_tests() ? 8 : 1, [&](const std::string& from, int n) {
    return ask(siege.server.port, "POST", "/fracture?seed=" + std::to_string(n), kObj + kGzip, body, from)
        .status;
  });
  EXPECT_LE(siege.neighbours->worst_wait(), kLongestWait);
  siege.judge("BodiesThatUnfold",
              "30 gzip bodies of 61 KB: collisions take up to 1.9 s, 12 of 12 end in 504 on a busy machine",
              Siege::Refusals::kNone);
}

TEST(TransportAttack, HeadsOfFigures) {
  Siege siege({"--memory", "2GiB"});
  const Reply large = ask(siege.server.port, "POST", "/fracture?sites=5000", kObj, kCube);
  ASSERT_EQ(large.status, 200);
  // The cost of one such request for the server, measured while nobody else sends requests.
  const auto cost = [&](const std::string& method, const std::string& path) {
    constexpr int kTimes = 10;
    const double begin = processor_seconds(siege.server.pid());
    for (int k = 0; k < kTimes; ++k)
      EXPECT_EQ(ask(siege.server.port, method, path, "Accept: application/json\r\n").status, 200);
    return 1e3 * (processor_seconds(siege.server.pid()) - begin) / kTimes;
  };
  siege.neighbours->stop();
  const double head = cost("HEAD", large.header("content-location")), version = cost("GET", "/version");
  EXPECT_LE(head, 10 * version + 5) << "ms of processor";
  siege.neighbours = std::make_unique<Neighbours>(siege.server);
  siege.attack(4, full_tests() ? 400 : 50, [&](const std::string& from, int) {
    return ask(siege.server.port, "HEAD", large.header("content-location"), "Accept: application/json\r\n",
               "", from)
        .status;
  });
  EXPECT_LE(siege.neighbours->worst_wait(), kLongestWait);
  char text[100];
  std::snprintf(text, sizeof text, "a HEAD costs %.2f ms of processor, GET /version %.2f ms", head, version);
  siege.judge("HeadsOfFigures", "the GLB is parsed on the only I/O thread: /version takes 1 to 9 s",
              Siege::Refusals::kNone, text);
}

TEST(TransportAttack, AnswersThatNobodyReads) {
  // Each reader requests a large answer and does not read it, until the server loses patience.
  Siege siege({"--max-answers", "64MiB", "--write-stall", "2", "--result-cache", "16MiB"});
  constexpr int kReaders = 48;
  std::vector<std::unique_ptr<RawClient>> idle;
  for (int k = 0; k < kReaders; ++k) {
    idle.push_back(std::make_unique<RawClient>(siege.server.port, "127.0.1." + std::to_string(k + 1)));
    idle.back()->send("POST /fracture?sites=" + std::to_string(full_tests() ? 4000 : 1500) +
                      "&seed=" + std::to_string(k) + " HTTP/1.1\r\nHost: localhost\r\n" + kObj +
                      "Content-Length: " + std::to_string(kCube.size()) + "\r\n\r\n" + kCube);
  }
  const auto connections = [&] {
    return parse_exposition(ask(siege.server.admin_port, "GET", "/metrics").body)["fracture_connections"];
  };
  EXPECT_TRUE(eventually(kPatience, "them to be cut", [&] { return connections() <= 2; })) << connections();
  const Exposition m = parse_exposition(ask(siege.server.admin_port, "GET", "/metrics").body);
  siege.judge("AnswersThatNobodyReads", "not counted", Siege::Refusals::kAllowed,
              std::to_string(static_cast<int>(m["fracture_answers_undelivered_total"])) + " of " +
                  std::to_string(kReaders) + " cut, the others refused or taken by the kernel");
}

// Found by hand: a body of one-byte chunks, or of chunk extensions, took 0.3 s of the I/O thread per MiB.
TEST(TransportAttack, ChunksOfOneByte) {
  Siege siege({"--memory", "2GiB"});
  siege.neighbours->stop();
  const std::string head =
      "POST /fracture HTTP/1.1\r\nHost: localhost\r\n" + kObj + "Transfer-Encoding: chunked\r\n\r\n";
  const std::string one = many("1\r\n#\r\n", 10'000), three = many("3\r\n###\r\n", 10'000),
                    extension = many("1;" + std::string(500, 'e') + "\r\n#\r\n", 100);
  /// Sends such chunks until it is stopped, at most `most` bytes.
  const auto send = [&](const std::string& chunks, std::size_t most, const std::string& from) {
    RawClient client(siege.server.port, from);
    std::size_t sent = 0;
    if (client.send(head))
      while (sent < most && client.send(chunks)) sent += chunks.size();
    return sent;
  };
  constexpr std::size_t kMiB = 1u << 20, kMost = 8 * kMiB;
  const double begin = processor_seconds(siege.server.pid());
  const std::size_t sent = send(three, kMost, "127.0.1.1");
  const double cost = (processor_seconds(siege.server.pid()) - begin) / (static_cast<double>(sent) / kMiB);
#ifndef FRACTURE_SANITIZED
  EXPECT_LE(cost, 0.05) << "processor seconds for each MiB of three-byte chunks";
#endif
  siege.neighbours = std::make_unique<Neighbours>(siege.server);
  siege.attack(4, full_tests() ? 10 : 1, [&](const std::string& from, int n) {
    send(n % 2 == 0 ? one : extension, kMost, from);
    return 0;
  });
  siege.statuses.clear();
  EXPECT_LE(siege.neighbours->worst_wait(), kLongestWait);
  char text[100];
  std::snprintf(text, sizeof text, "%.3f s of processor for each MiB of three-byte chunks", cost);
  siege.judge("ChunksOfOneByte", "0.3 s of the I/O thread for each MiB, of 400 MiB for a body of 50",
              Siege::Refusals::kNone, text);
}

TEST(TransportAttack, IdleAdminConnections) {
  Siege siege({"--header-timeout", "60", "--idle", "60"});  // longer than a probe waits
  std::vector<std::unique_ptr<RawClient>> idle;
  for (int k = 0; k < 100; ++k) {
    idle.push_back(std::make_unique<RawClient>(siege.server.admin_port, "127.0.1.1"));
    if (k % 2 == 1) idle.back()->send("GET /livez HT");
  }
  const int until = siege.neighbours->probes + 20;
  EXPECT_TRUE(eventually(kPatience, "/livez to answer",
                         [&] { return siege.neighbours->probes >= until || siege.neighbours->failed != 0; }));
  siege.judge("IdleAdminConnections", "32 of them: /livez does not answer", Siege::Refusals::kNone);
}

}  // namespace
}  // namespace fracture::test
