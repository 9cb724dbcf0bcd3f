// Runs the server as a separate process and writes a report of its timed bounds to standard output, as
// Markdown. Missed bounds are marked. The exit code is 0 if every answer was right.
//
// Usage: bench_overload [quick]
#include <sys/resource.h>

#include <cstdio>
#include <cstring>

#include "tests/bench/server/load.hpp"
#include "tests/server/support/child_process.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/server_process.hpp"

namespace fracture::bench {
namespace {

using test::ask;
using test::Exposition;
using test::ServeProcess;

const std::string kCube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// A new request each time, so that every one is computed.
std::string fracture(std::size_t sites, std::size_t seed, const std::string& fields = "") {
  return "POST /fracture?sites=" + std::to_string(sites) + "&seed=" + std::to_string(seed) +
         " HTTP/1.1\r\nHost: a\r\nContent-Type: model/obj\r\n" + fields +
         "Content-Length: " + std::to_string(kCube.size()) + "\r\n\r\n" + kCube;
}

bool wrong = false;

void row(const char* what, double value, const char* unit, const char* bound, bool kept) {
  std::printf("| %s | %.4g %s | %s | %s |\n", what, value, unit, bound, kept ? "kept" : "**missed**");
  std::fflush(stdout);
}
void section(const char* title) {
  std::printf("\n## %s\n\n| what | measured | bound | |\n|---|---|---|---|\n", title);
}
void must(bool condition, const char* what) {
  if (condition) return;
  std::printf("\nWRONG: %s\n", what);
  wrong = true;
}

Exposition metrics(ServeProcess& server) {
  return test::parse_exposition(ask(server.admin_port, "GET", "/metrics").body);
}

/// CPU seconds of a process so far.
double cpu_seconds(pid_t pid) {
  const std::string stat = test::read_file("/proc/" + std::to_string(pid) + "/stat");
  std::istringstream words(stat.substr(stat.rfind(')') + 2));
  std::string skipped;
  for (int i = 0; i < 11; ++i) words >> skipped;
  double user = 0, system = 0;
  words >> user >> system;
  return (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

void start_and_upload() {
  section("Start and upload");
  double start = 1e9;
  for (int i = 0; i < 5; ++i) {
    const Clock::time_point begin = Clock::now();
    ServeProcess server;
    must(ask(server.admin_port, "GET", "/readyz").status == 200, "ready after the start");
    start = std::min(start, milliseconds(Clock::now() - begin));
  }
  row("cold start to ready, best of 5", start, "ms", "< 300 ms", start < 300);

  ServeProcess server;
  const std::string body(2u << 20, 'x');
  double best = 1e9;
  for (int i = 0; i < 5; ++i) {
    test::RawClient client(server.port);
    const Clock::time_point begin = Clock::now();
    client.send("POST /fracture?format=obj HTTP/1.1\r\nHost: a\r\nExpect: 100-continue\r\nContent-Length: " +
                std::to_string(body.size()) + "\r\n\r\n");
    const auto interim = client.receive();
    must(interim && interim->status == 100, "100 Continue");
    client.send(body);
    const auto reply = client.receive();
    must(reply && reply->status == 422, "two MiB of nonsense are refused");
    best = std::min(best, milliseconds(Clock::now() - begin));
  }
  row("2 MiB upload with Expect: 100-continue, best of 5", best, "ms", "< 1000 ms", best < 1000);
}

void overload(std::chrono::milliseconds duration) {
  constexpr std::size_t kSites = 300;
  constexpr double kDeadline = 1000;
  const std::string with_deadline = "Request-Timeout: 1\r\n";
  ServeProcess server({"--max-connections-per-address", "1000", "--max-queue", "10000"});
  std::atomic<std::size_t> seed{1};
  const MakeRequest make = [&](std::size_t) { return fracture(kSites, seed++, with_deadline); };
  closed_loop(server.port, 4, std::chrono::milliseconds(2000), make);  // warm-up
  const Load peak = closed_loop(server.port, 4, duration, make);
  const double capacity = peak.rate(200);

  std::atomic<bool> stop{false};
  std::vector<double> admin;
  std::thread prober([&] {
    while (!stop) {
      const Clock::time_point begin = Clock::now();
      must(ask(server.admin_port, "GET", "/readyz").status == 200, "ready under overload");
      admin.push_back(milliseconds(Clock::now() - begin));
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  });
  const Load load = open_loop(server.port, 256, duration, 4 * capacity, make);
  stop = true;
  prober.join();

  const auto accepted = load.latencies([](const Sample&s) { return s.status == 200; }),
             refused = load.latencies([](const Sample&s) { return s.status == 503; });
  const std::size_t untold =
      static_cast<std::size_t>(std::count_if(load.samples.begin(), load.samples.end(), [](const Sample& s) {
        return s.status == 503 && !s.retry_after;
      }));
  must(untold == 0, "a 503 without Retry-After");
  must(load.count(0) == 0, "a request without an answer");
  section("Overload: four times the capacity for a while");
  row("capacity, closed loop", capacity, "/s", "", true);
  row("offered", static_cast<double>(load.samples.size()) / load.seconds, "/s", "4 x capacity",
      static_cast<double>(load.samples.size()) / load.seconds > 3.5 * capacity);
  row("goodput", load.rate(200) / capacity, "x capacity", ">= 0.8", load.rate(200) >= 0.8 * capacity);
  row("accepted, p99", quantile(accepted, 0.99), "ms", "<= 1000 ms (the deadline)",
      quantile(accepted, 0.99) <= kDeadline);
  row("rejected (503 with Retry-After)", load.rate(503), "/s", "", true);
  row("rejected, p50", quantile(refused, 0.5), "ms", "< 5 ms", quantile(refused, 0.5) < 5);
  row("rejected, p99", quantile(refused, 0.99), "ms", "< 5 ms", quantile(refused, 0.99) < 5);
  row("past its deadline (504)", load.rate(504), "/s", "", true);
  row("admin listener, p99", quantile(admin, 0.99), "ms", "< 50 ms", quantile(admin, 0.99) < 50);
  row("left late by the generator", static_cast<double>(load.late), "requests", "", true);
}

void slow_clients() {
  const auto program = test::find_program("slowhttptest");
  section("500 slow clients beside a foreground of 2");
  if (!program) {
    std::printf("| slowhttptest is not installed | | | |\n");
    return;
  }
  ServeProcess server({"--max-connections-per-address", "1000"});
  std::atomic<std::size_t> seed{1};
  const MakeRequest make = [&](std::size_t) { return fracture(20, seed++); };
  const auto p99 = [&](std::chrono::milliseconds duration) {
    const Load load = closed_loop(server.port, 2, duration, make);
    must(load.count(200) == load.samples.size(), "a foreground request failed");
    return quantile(load.latencies([](const Sample&) { return true; }), 0.99);
  };
  const auto large = ask(server.port, "POST", "/fracture?sites=3000", "Content-Type: model/obj\r\n", kCube);
  p99(std::chrono::milliseconds(1000));
  const double idle = p99(std::chrono::milliseconds(4000));
  row("foreground alone, p99", idle, "ms", "", true);
  const std::string base = "http://127.0.0.1:" + std::to_string(server.port),
                    post = base + "/fracture?format=obj", get = base + large.header("content-location");
  const std::pair<const char*, std::vector<std::string>> modes[] = {
      {"slow headers", {"-H", "-i", "1", "-u", post}},
      {"slow bodies", {"-B", "-i", "1", "-s", "8192", "-u", post}},
      {"slow readers", {"-X", "-w", "10", "-y", "20", "-n", "2", "-z", "8", "-u", get}}};
  for (const auto& [name, mode] : modes) {
    std::vector<std::string> arguments = {*program, "-c", "500", "-r", "500", "-l", "6", "-v", "1"};
    arguments.insert(arguments.end(), mode.begin(), mode.end());
    const test::TemporaryFolder folder;
    test::ChildProcess slow(arguments, folder / "output");
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));  // until they are connected
    const double ratio = p99(std::chrono::milliseconds(4000)) / idle;
    row((std::string("foreground with ") + name + ", p99").c_str(), ratio, "x idle", "< 2", ratio < 2);
    slow.wait();
  }
}

void resets() {
  // Nothing may be refused: every client must have work that waits or runs.
  ServeProcess server({"--max-connections-per-address", "1000", "--max-queue", "1000", "--deadline", "36000",
                       "--max-working", "1023GiB"});
  std::vector<std::unique_ptr<test::RawClient>> clients;
  for (std::size_t i = 0; i < 100; ++i) {
    clients.push_back(std::make_unique<test::RawClient>(server.port));
    clients.back()->send(fracture(20'000, i));
  }
  while (metrics(server)["fracture_flights"] < 100) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  for (const auto& client : clients) client->reset();
  const Clock::time_point reset = Clock::now();
  // Idle: no tick of the CPU clock (10 ms) in 50 ms.
  double idle_after = -1;
  Clock::time_point last_used = reset;
  for (double before = cpu_seconds(server.pid()); idle_after < 0;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const double now = cpu_seconds(server.pid());
    if (now > before) last_used = Clock::now();
    before = now;
    if (Clock::now() - last_used > std::chrono::milliseconds(50))
      idle_after = milliseconds(last_used - reset);
    if (Clock::now() - reset > std::chrono::seconds(60)) break;
  }
  must(metrics(server)["fracture_work_abandoned_total"] == 100, "every reset is seen");
  section("100 clients reset after their upload");
  row("last CPU time used after the resets", idle_after, "ms", "< 100 ms",
      idle_after >= 0 && idle_after < 100);
}

void memory(std::size_t requests) {
  // Caches fill up to their budgets, which is not a leak. So the caches are small and the warm-up is long.
  ServeProcess server({"--max-connections-per-address", "1000", "--mesh-cache", "4MiB", "--diagram-cache",
                       "4MiB", "--result-cache", "4MiB"});
  const MakeRequest mixed = [](std::size_t n) -> std::string {
    switch (n % 10) {
      case 0:
        return "GET /version HTTP/1.1\r\nHost: a\r\n\r\n";
      case 1:
        return "GET /limits HTTP/1.1\r\nHost: a\r\n\r\n";
      case 2:
        return "GET /nothing HTTP/1.1\r\nHost: a\r\n\r\n";
      case 3:
        return fracture(0, 1);
      case 4:
        return "POST /fracture?sites=3 HTTP/1.1\r\nHost: a\r\nContent-Type: model/obj\r\nTransfer-Encoding: "
               "chunked\r\n\r\n4\r\nmesh\r\n0\r\n\r\n";
      case 5:
        return "POST /fracture HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: gzip\r\n\r\n";
      case 6:
        return fracture(4, n);
      default:
        return fracture(4, n % 50);
    }
  };
  const auto resident = [&] { return metrics(server)["process_resident_memory_bytes"]; };
  std::vector<std::pair<double, double>> points;
  const std::size_t step = requests / 50;
  std::size_t done = 0;
  for (int i = 0; i < 50; ++i) {
    const Load load = closed_loop_count(server.port, 8, step, [&](std::size_t n) { return mixed(done + n); });
    must(load.count(0) == 0, "a request without an answer");
    done += step;
    if (i >= 20) points.emplace_back(static_cast<double>(done), resident());
  }
  double x = 0, y = 0, xx = 0, xy = 0;
  const double n = static_cast<double>(points.size());
  for (const auto& [a, b] : points) x += a, y += b, xx += a * a, xy += a * b;
  const double slope = (n * xy - x * y) / (n * xx - x * x);
  section("Memory over mixed requests");
  row("requests", static_cast<double>(done), "", "", true);
  row("resident at the end", resident() / 1048576, "MiB", "", true);
  row("slope after 40 % of them", slope, "bytes/request", "< 1024", slope < 1024);
}

}  // namespace
}  // namespace fracture::bench

int main(int argc, char** argv) {
  using namespace fracture::bench;
  const bool quick = argc > 1 && std::strcmp(argv[1], "quick") == 0;
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
  double loads[3] = {};
  const int known = getloadavg(loads, 3);
  std::printf("# Server benchmark\n\n%u cores, which the generator shares; load average before: %.2f\n",
              std::thread::hardware_concurrency(), known > 0 ? loads[0] : -1.0);
  start_and_upload();
  overload(std::chrono::milliseconds(quick ? 3000 : 10'000));
  slow_clients();
  resets();
  memory(quick ? 5000 : 50'000);
  return wrong ? 1 : 0;
}
