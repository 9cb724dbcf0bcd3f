// Compares the bytes that an Allowance counts (common/base/product.hpp) with the resident memory. Each case runs
// in its own process with one thread. The result is the peak above the memory of the input.
//
//   bench_products [--case NAME]
//
// Exits with 1 if more is resident than 1.3 times the count plus 16 MiB, because an admitted computation would
// then take more memory than was reserved for it.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/allocator/allocator.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/support/growth_families.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::bench {
namespace {

struct Case {
  const char* name;
  std::function<Mesh()> mesh;
  std::uint32_t sites;
  double rough_amplitude = 0;
};

const Case kCases[] = {
    {"sphere of 1,000,000, 3 sites", [] { return test::sphere_with(1'000'000); }, 3},
    {"sphere of 200,000, 1000 sites", [] { return test::sphere_with(200'000); }, 1000},
    {"cube, 2000 sites", [] { return test::cube(); }, 2000},
    {"cube, 50,000 sites", [] { return test::cube(); }, 50'000},
    {"cube, 200 rough sites", [] { return test::cube(); }, 200, 0.05},
    {"sponge, 500 sites", [] { return test::menger_sponge(4); }, 500},
    {"20³ cubes, 500 sites", [] { return test::cube_field(20); }, 500},
    {"300,000 triangles without a side, 50 sites",
     [] {
       Mesh mesh = test::cube(160);
       mesh.triangles.resize(mesh.triangles.size() / 6 * 5);
       mesh.material.resize(mesh.triangles.size());
       mesh.node.resize(mesh.triangles.size());
       return mesh;
     },
     50},
};

double status(const char* field) {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);)
    if (line.rfind(field, 0) == 0) return 1024 * std::strtod(line.c_str() + std::strlen(field) + 1, nullptr);
  return 0;
}

/// The peak above the resident memory at construction.
class Peak {
 public:
  Peak() {
    return_free_memory();
    std::ofstream("/proc/self/clear_refs") << 5;
    before_ = status("VmRSS:");
  }
  double more() const { return std::max(0.0, status("VmHWM:") - before_); }

 private:
  double before_;
};

bool report(const char* name, const char* stage, double counted, double resident) {
  constexpr double kMiB = 1 << 20;
  const bool within = resident <= 1.3 * counted + 16 * kMiB;
  std::printf("| %s | %s | %.1f | %.1f | %.2f |%s\n", name, stage, counted / kMiB, resident / kMiB,
              resident / std::max(1.0, counted), within ? "" : " OVER");
  return within;
}

/// Runs in the child.
bool measure(const Case& c) {
  const auto mesh = std::make_shared<const Mesh>(c.mesh());
  FractureParameters parameters;
  parameters.sites = c.sites;
  parameters.roughness.amplitude = c.rough_amplitude;
  Allowance allowance(0, UINT64_MAX, [](std::uint64_t) { return Allowance::Answer::kGranted; });
  Execution execution;
  execution.allowance = &allowance;
  std::uint64_t most = 0;
  execution.watch = [&] { most = std::max(most, allowance.bytes()); };

  execution.made(Product::kSurfaceTriangles, mesh->triangles.size());  // as the service does
  const Peak solid_peak;
  const Expected<Solid> solid = make_solid(mesh, {}, execution);
  if (!solid) {
    std::printf("| %s | refused: %s |\n", c.name, solid.error().detail.c_str());
    return false;
  }
  bool within =
      report(c.name, "solid", static_cast<double>(std::max(most, allowance.bytes())), solid_peak.more());

  Allowance second(0, UINT64_MAX, [](std::uint64_t) { return Allowance::Answer::kGranted; });
  execution.allowance = &second;
  most = 0;
  execution.watch = [&] { most = std::max(most, second.bytes()); };
  const Peak peak;
  StageTimings timings;
  const Expected<Diagram> diagram = make_diagram(*solid, parameters, execution, timings);
  if (!diagram) return false;
  const Expected<FracturedSolid> made = fracture::fracture(*solid, *diagram, parameters, execution, timings);
  if (!made || made->set.fragments.empty()) return false;
  within &= report(c.name, "fragments", static_cast<double>(std::max(most, second.bytes())), peak.more());
  for (std::size_t k = 0; k < kProducts; ++k)
    if (const std::uint64_t count = second.made(static_cast<Product>(k)); count > 0)
      std::printf("    %llu %s\n", static_cast<unsigned long long>(count), name_of(static_cast<Product>(k)));
  return within;
}

bool run(const Case& c) {
  std::fflush(stdout);
  const pid_t child = ::fork();
  if (child == 0) {
    const bool within = measure(c);
    std::fflush(stdout);
    ::_exit(within ? 0 : 1);
  }
  int code = 0;
  return child > 0 && ::waitpid(child, &code, 0) == child && WIFEXITED(code) && WEXITSTATUS(code) == 0;
}

}  // namespace
}  // namespace fracture::bench

int main(int argc, char** argv) {
  const char* only = argc == 3 && std::strcmp(argv[1], "--case") == 0 ? argv[2] : nullptr;
  std::printf("| case | stage | counted MiB | resident MiB | resident / counted |\n|---|---|---|---|---|\n");
  bool within = true;
  for (const fracture::bench::Case& c : fracture::bench::kCases)
    if (!only || std::strcmp(only, c.name) == 0) within &= fracture::bench::run(c);
  return within ? 0 : 1;
}
