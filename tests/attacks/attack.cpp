#include "tests/attacks/attack.hpp"

#include <algorithm>
#include <cstdio>

#include "tests/docker/load.hpp"

namespace fracture::test {
namespace {

constexpr std::uint64_t kMiB = 1u << 20;

struct Line {
  std::string attack, measured, before;
};
std::vector<Line>& lines() {
  static std::vector<Line> all;
  return all;
}

class Table : public testing::Environment {
  void TearDown() override {
    if (lines().empty()) return;
    std::size_t wide = 0;
    for (const Line& line : lines()) wide = std::max(wide, line.attack.size());
    std::printf("\n");
    const int width = static_cast<int>(wide), indent = width + 2;
    for (const Line& line : lines())
      std::printf("%-*s  %s\n%*s(before: %s)\n", width, line.attack.c_str(), line.measured.c_str(), indent,
                  "", line.before.c_str());
  }
};
[[maybe_unused]] testing::Environment* const table = testing::AddGlobalTestEnvironment(new Table);

std::vector<std::string> with_defaults(std::vector<std::string> settings) {
  const auto unless_given = [&settings](const char* name, const char* value) {
    if (std::find(settings.begin(), settings.end(), name) == settings.end())
      settings.insert(settings.end(), {name, value});
  };
  unless_given("--memory", "768MiB");
  unless_given("--import-workers", "2");
  unless_given("--realtime-deadline", "60");
  return settings;
}

/// The value of --memory, such as "768MiB" or "2GiB", in bytes.
std::uint64_t memory_of(const std::vector<std::string>& settings) {
  const auto at = std::find(settings.begin(), settings.end(), "--memory");
  const std::string value = at == settings.end() ? "768MiB" : *(at + 1);
  return std::stoull(value) * (value.find("GiB") == std::string::npos ? kMiB : 1024 * kMiB);
}

}  // namespace

void report(const std::string& attack, const std::string& measured, const std::string& before) {
  lines().push_back({attack, measured, before});
}

// -- neighbours

Neighbours::Neighbours(const ServeProcess& server) : pid_(server.pid()) {
  threads_.emplace_back([this, port = server.port] { play(port); });
  threads_.emplace_back([this, port = server.port, admin = server.admin_port] { probe(port, admin); });
}

Neighbours::~Neighbours() { stop(); }

void Neighbours::stop() {
  stop_ = true;
  for (std::thread& thread : threads_)
    if (thread.joinable()) thread.join();
}

void Neighbours::play(std::uint16_t port) {
  const StoredMesh mesh(1);
  GameClient client(port);
  for (int seed = 1; !stop_; ++seed) {
    try {
      const double begin = processor_seconds(pid_);
      const Reply reply = client.fracture(mesh, seed);
      time(processor_seconds(pid_) - begin);
      if (reply.status == 200)
        ++served;
      else if (reply.status == 503 && !reply.header("retry-after").empty())
        ++refused;
      else
        fail("a collision: " + std::to_string(reply.status) + " " + reply.body);
    } catch (const std::runtime_error& e) {
      fail(std::string("a collision: ") + e.what());
    }
    // pause: neighbours ask at the pace of a game, not as fast as they can
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

void Neighbours::probe(std::uint16_t port, std::uint16_t admin_port) {
  for (int k = 0; !stop_; ++k) {
    const char* const path = k % 2 == 0 ? "/version" : "/livez";
    try {
      const double begin = processor_seconds(pid_);
      const Reply reply = ask(k % 2 == 0 ? port : admin_port, "GET", path);
      time(processor_seconds(pid_) - begin);
      if (reply.status == 200)
        ++probes;
      else
        fail(path + std::string(": ") + std::to_string(reply.status) + " " + reply.body);
    } catch (const std::runtime_error& e) {
      fail(path + std::string(": ") + e.what());
    }
    // pause: neighbours ask at the pace of a game, not as fast as they can
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

void Neighbours::time(double seconds) {
  const std::lock_guard lock(mutex_);
  worst_ = std::max(worst_, seconds);
}

void Neighbours::fail(const std::string& what) {
  const std::lock_guard lock(mutex_);
  if (failed++ == 0) first_failure_ = what.substr(0, 1000);
}

std::string Neighbours::first_failure() const {
  const std::lock_guard lock(mutex_);
  return first_failure_;
}

double Neighbours::worst_wait() const {
  const std::lock_guard lock(mutex_);
  return worst_;
}

// -- sieges

Siege::Siege(std::vector<std::string> settings)
    : server(with_defaults(settings)), memory(memory_of(settings)), peak_(server.pid()) {
  neighbours = std::make_unique<Neighbours>(server);
  // Each kind of neighbour gets its first answer before the attack begins.
  require_eventually(kPatience, "the neighbours to be served", [&] {
    if (neighbours->failed != 0) throw std::runtime_error(neighbours->first_failure());
    return neighbours->served > 0 && neighbours->probes > 1;
  });
}

void Siege::attack(int attackers, int least, const std::function<int(const std::string& from, int n)>& once) {
  const int end = neighbours->served + kServed;
  const auto give_up = std::chrono::steady_clock::now() + kPatience;
  std::mutex mutex;
  std::vector<std::thread> threads;
  for (int attacker = 0; attacker < attackers; ++attacker)
    threads.emplace_back([&, attacker, from = "127.0.1." + std::to_string(attacker + 1)] {
      for (int k = 0; k < least || neighbours->served < end; ++k) {
        if (neighbours->failed != 0 || std::chrono::steady_clock::now() > give_up) break;
        int status = 0;
        try {
          status = once(from, k * attackers + attacker);
        } catch (const std::runtime_error&) {
          // The attacker was cut off, or the server died; the neighbours tell which.
          // pause: an attacker that was cut off returns, but not at once
          std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        const std::lock_guard lock(mutex);
        ++statuses[status];
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_GE(neighbours->served, end) << "the neighbours were not served during the attack";
}

std::string Siege::answers() const {
  std::string text;
  for (const auto& [status, count] : statuses)
    text += (text.empty() ? "" : ", ") + (status ? std::to_string(status) : std::string("cut off")) + ": " +
            std::to_string(count);
  return text;
}

void Siege::judge(const std::string& attack, const std::string& before, Refusals refusals,
                  const std::string& more) {
  neighbours->stop();
  const std::uint64_t peak = peak_.bytes();
  char text[300];
  std::snprintf(text, sizeof text,
                "%llu of %llu MiB; neighbours %d served, %d refused, %d failed, waited for %.0f ms of "
                "processor at most",
                static_cast<unsigned long long>(peak / kMiB), static_cast<unsigned long long>(memory / kMiB),
                neighbours->served + neighbours->probes, neighbours->refused.load(),
                neighbours->failed.load(), 1e3 * neighbours->worst_wait());
  report(attack,
         text + (statuses.empty() ? "" : "; attackers " + answers()) + (more.empty() ? "" : "; " + more),
         before);
#ifndef FRACTURE_SANITIZED
  EXPECT_LE(peak, memory) << attack << ": " << peak / kMiB << " MiB resident";
#endif
  EXPECT_EQ(neighbours->failed, 0) << attack << ": " << neighbours->first_failure();
  if (refusals == Refusals::kNone) {
    EXPECT_EQ(neighbours->refused, 0) << attack;
  }
  EXPECT_EQ(statuses.count(500), 0u) << attack << ": " << answers();
  ASSERT_TRUE(server.alive()) << attack << " ended the server";
  EXPECT_EQ(server.stop(), 0) << attack;
}

}  // namespace fracture::test
