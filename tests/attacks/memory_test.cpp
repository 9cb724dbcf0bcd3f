// Small requests that expand, in a server with little memory. The resident memory stays within the server's
// limit, others are served, and the memory is given back.
#include <algorithm>
#include <sstream>

#include "tests/attacks/attack.hpp"
#include "tests/attacks/bodies.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/gzip.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

struct Attack {
  const char* name;
  const char* before;
  /// Sends the n-th request to this port. Returns its status.
  std::function<int(std::uint16_t port, const std::string& from, int n)> send;
  /// The statuses that a server with the limit may return.
  std::vector<int> allowed;
};

/// Every attacker sends different bodies, so that no cache saves the server work.
const Attack kAttacks[] = {
    {"RepeatedParameters",
     "1.2 to 2 GB, quadratic",
     [](std::uint16_t port, const std::string& from, int) {
       static const std::string body = gzip(repeated_parameters(80'000, 250'000));
       return ask(port, "POST", "/fracture", kForm + kGzip, body, from).status;
     },
     {400, 429, 503}},
    {"PreambleOfAForm",
     "200 MB kept for the mesh's life, 6 of them 1,220 MB",
     [](std::uint16_t port, const std::string& from, int n) {
       static const std::string body = gzip(std::string(60u << 20, 'x') + "\r\n" + form_of("{}"));
       return ask(port, "POST", "/meshes?weld_tolerance=1e-" + std::to_string(4 + n % 8), kForm + kGzip, body,
                  from)
           .status;
     },
     {400, 413, 429, 503}},
    {"EpilogueOfAForm",
     "200 MB kept for the mesh's life, 6 of them 1,220 MB",
     [](std::uint16_t port, const std::string& from, int n) {
       static const std::string body = gzip(form_of("{}") + std::string(60u << 20, 'x'));
       return ask(port, "POST", "/meshes?weld_tolerance=1e-" + std::to_string(4 + n % 8), kForm + kGzip, body,
                  from)
           .status;
     },
     {400, 413, 429, 503}},
    {"ExtrasOfMillions",
     "3 of 8 KB held as 64 MB each, counted as 7,788 bytes",
     [](std::uint16_t port, const std::string& from, int n) {
       static const std::string extras = "{\"extras\":[0" + many(",0", 4'000'000) + "]}";
       return ask(port, "POST", "/meshes", kGltf + kGzip, gzip(gltf_with("", extras, n)), from).status;
     },
     {201, 413, 422, 429, 503}},
    {"InstancesOfMillions",
     "814 bytes become 3.6 M triangles: 4 MiB reserved, 470 MB used",
     [](std::uint16_t port, const std::string& from, int n) {
       return ask(port, "POST", "/fracture?sites=3", kGltf, gltf_of_many_instances(n), from).status;
     },
     {200, 413, 422, 429, 503, 504}},
};

/// The lines of an exposition that describe memory.
[[maybe_unused]] std::string memory_lines(const std::string& metrics) {
  std::istringstream lines(metrics);
  std::string some;
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("fracture_memory_")) some += line + "\n";
  return some;
}

/// Prints the attack's name in failures, not its bytes.
void PrintTo(const Attack& attack, std::ostream* out) { *out << attack.name; }

struct MemoryAttack : testing::TestWithParam<Attack> {};

TEST_P(MemoryAttack, WhatIsResidentStaysWithinTheBudgetAndOthersAreServed) {
  Siege siege;
  siege.attack(4, full_tests() ? 16 : 2,
               [&](const std::string& from, int n) { return GetParam().send(siege.server.port, from, n); });
  for (const auto& [status, count] : siege.statuses)
    EXPECT_TRUE(std::count(GetParam().allowed.begin(), GetParam().allowed.end(), status))
        << count << " times " << status;
  siege.neighbours->stop();
  // At rest, the server holds no more memory than the reported amount plus the base of every server.
  std::string metrics;
  [[maybe_unused]] const auto at_rest = [&] {
    metrics = ask(siege.server.admin_port, "GET", "/metrics").body;
    const Exposition m = parse_exposition(metrics);
    return m["fracture_memory_limit_bytes"] == static_cast<double>(siege.memory) &&
           m.sum("fracture_memory_resident_bytes") <=
               1.3 * m.sum("fracture_memory_reserved_bytes") + m["fracture_memory_base_bytes"];
  };
  if (siege.server.alive()) {
#ifndef FRACTURE_SANITIZED
    EXPECT_TRUE(eventually(std::chrono::seconds(30), "what was held to be given back", at_rest))
        << memory_lines(metrics);
#endif
    const Exposition m = parse_exposition(ask(siege.server.admin_port, "GET", "/metrics").body);
    EXPECT_LE(1.3 * m.sum("fracture_memory_budget_bytes") + m["fracture_memory_base_bytes"],
              static_cast<double>(siege.memory));
  }
  siege.judge(GetParam().name, GetParam().before);
}

INSTANTIATE_TEST_SUITE_P(Rows, MemoryAttack, testing::ValuesIn(kAttacks),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace fracture::test
