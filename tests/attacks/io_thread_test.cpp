// Small requests that once occupied the I/O thread, for which everybody waits. A few bytes cost milliseconds,
// without a token or a share to charge. Now their work is done only once, or in the pool. The tests measure
// how long each of the thread's turns takes.
#include "tests/attacks/attack.hpp"
#include "tests/attacks/bodies.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

Exposition metrics_of(const ServeProcess& server) {
  return parse_exposition(ask(server.admin_port, "GET", "/metrics").body);
}

/// Numbers of turns of the io threads, by their processor time.
struct Turns {
  explicit Turns(const ServeProcess& server) {
    const Exposition m = metrics_of(server);
    all = m["fracture_io_turn_seconds_count"];
    over_limit = all - m["fracture_io_turn_seconds_bucket{le=\"0.0002\"}"];
    over_ten_limits = all - m["fracture_io_turn_seconds_bucket{le=\"0.002\"}"];
  }
  double all, over_limit, over_ten_limits;
};

/// Runs the attack and judges it. Before the fix, each of its requests caused such a long turn.
void attack(Siege& siege, const std::string& name, const std::string& before, int attackers, int least,
            const std::function<int(const std::string& from, int n)>& once) {
  [[maybe_unused]] const Turns begin(siege.server);
  siege.attack(attackers, least, once);
  int requests = 0;
  for (const auto& [status, count] : siege.statuses) requests += count;
  EXPECT_GE(requests, attackers * least);
#ifndef FRACTURE_SANITIZED  // Everything takes ten times as long there.
  const Turns end(siege.server);
  EXPECT_GT(end.all - begin.all, requests) << "every request takes some turns";
  EXPECT_LT(end.over_limit - begin.over_limit, 0.1 * (end.all - begin.all)) << siege.answers();
  EXPECT_LT(end.over_ten_limits - begin.over_ten_limits, 0.1 * requests) << siege.answers();
#endif
  EXPECT_EQ(metrics_of(siege.server)["fracture_io_bulk_turns_total"], 0) << "more than kMostInTurn in a turn";
  siege.judge(name, before, Siege::Refusals::kNone);
}

TEST(IoThreadAttack, HeadsOfTheLargestFileOfThePage) {
  Siege siege;
  if (ask(siege.server.port, "GET", "/page/play.js").status == 404) GTEST_SKIP() << "built without its page";
  attack(siege, "HeadsOfThePage", "2.2 MB inflated for 48 bytes: GET /version takes 298 ms", 4,
         full_tests() ? 500 : 50, [&](const std::string& from, int) {
           return ask(siege.server.port, "HEAD", "/page/play.js", "", "", from).status;
         });
}

TEST(IoThreadAttack, AnAnswerOfManyParametersNamedInFewBytes) {
  Siege siege;
  std::string points;
  for (int k = 0; k < 1450; ++k)
    points +=
        (k > 0 ? ",[" : "[") + std::to_string(0.0006 * k) + ",0.5," + std::to_string(0.25 + 0.0001 * k) + "]";
  const Reply large = ask(siege.server.port, "POST", "/fracture", kForm + "Accept: application/json\r\n",
                          form_of("{\"pattern\":\"points\",\"points\":[" + points + "]}"));
  ASSERT_EQ(large.status, 200) << large.body.substr(0, 300);
  const std::string other =
      ask(siege.server.port, "POST", "/meshes", kObj, kCube + "#2\n").header("location");
  attack(siege, "NamedParameters", "2.3 ms on the io thread for 340 bytes, though they are refused", 4,
         full_tests() ? 500 : 50, [&](const std::string& from, int) {
           return ask(siege.server.port, "POST", other + "/fracture", kJson,
                      "{\"of\":\"" + large.header("content-location") +
                          "\",\"local_point\":[[0.5,0.5,0.5]],\"local_radius\":0.2,\"delta\":\"only\"}",
                      from)
               .status;
         });
  EXPECT_EQ(siege.statuses.begin()->first, 400) << siege.answers();
}

TEST(IoThreadAttack, EstimatesOfManyMaterialsAndHits) {
  Siege siege;
  const std::string mesh = ask(siege.server.port, "POST", "/meshes", kObj, kCube).header("location");
  std::string entries, points;
  for (int k = 0; k < 55; ++k) entries += (k > 0 ? ";a" : "a") + std::to_string(k) + ":ice";
  for (int k = 0; k < 48; ++k) points += k > 0 ? ",[1,1,1]" : "[1,1,1]";
  attack(siege, "Estimates", "2.3 ms on the io thread for 480 bytes: GET /version waits for seconds", 4,
         full_tests() ? 200 : 20, [&](const std::string& from, int n) {
           return n % 2 ? ask(siege.server.port, "POST", mesh + "/estimate?sites=2&assign=" + entries, "", "",
                              from)
                              .status
                        : ask(siege.server.port, "POST", mesh + "/estimate", kJson,
                              "{\"local_point\":[" + points + "],\"local_radius\":0.1}", from)
                              .status;
         });
  EXPECT_EQ(siege.statuses.begin()->first, 200) << siege.answers();
}

TEST(IoThreadAttack, ListsOfAFullQueue) {
  Siege siege({"--threads", "1", "--memory", "4GiB"});
  const std::string mesh = ask(siege.server.port, "POST", "/meshes", kObj, kCube).header("location");
  const auto job = [&](const std::string& body, const std::string& from) {
    return ask(siege.server.port, "POST", mesh + "/fracture", kJson + "Prefer: respond-async\r\n", body, from)
        .status;
  };
  EXPECT_EQ(job("{\"sites\":20000,\"lloyd\":50}", "127.0.2.1"), 202);
  int queued = 0;
  for (int client = 2; client < 8; ++client)
    for (int k = 0; k < 120; ++k)
      queued += job("{\"sites\":2,\"seed\":" + std::to_string(1000 * client + k) + "}",
                    "127.0.2." + std::to_string(client)) == 202;
  EXPECT_GE(queued, 200);
  attack(siege, "ListsOfAFullQueue", "the queue is sorted for each of a hundred jobs, under the pool's lock",
         4, full_tests() ? 200 : 20, [&](const std::string& from, int n) {
           return ask(siege.server.port, n % 2 ? "HEAD" : "GET",
                      n % 3 ? "/jobs?limit=100&state=queued" : "/jobs", "", "", from)
               .status;
         });
}

TEST(IoThreadAttack, HeadersOfThousandsOfParts) {
  Siege siege;
  const std::string commas = "Accept: " + many(",", 15'000) + "\r\nConnection: close\r\n",
                    fields = many("a:\r\n", 3'500);
  attack(siege, "HeadersOfManyParts", "half a millisecond for 15,000 commas", 4, full_tests() ? 500 : 50,
         [&](const std::string& from, int n) {
           return ask(siege.server.port, "GET", "/version", n % 2 ? commas : fields, "", from).status;
         });
  EXPECT_EQ(siege.statuses.begin()->first, 431) << siege.answers();
  EXPECT_EQ(siege.statuses.size(), 1u) << siege.answers();
}

}  // namespace
}  // namespace fracture::test
