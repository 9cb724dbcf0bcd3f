// Times single stages, and a whole fracture that is larger than any collision. Default: one thread.
//
//   bench_stages [--threads T] [--runs N] NAME...
//
//   canonical_100k   canonicalize() of the tetrahedralization of 100,000 random points
//   prepare_1M, _4M  make_solid() of a sphere with this many triangles
//   giant_100k       make_diagram(), fracture() with hulls and write_glb(): 100,000 sites in a sphere of 20k
//                    triangles
//
// Prints one line each: the shortest time of N runs in milliseconds (default 3), and a hash of the output,
// which is the same in each run.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/digest/digest.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/bench/delaunay_workloads.hpp"
#include "tests/bench/stopwatch.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::bench {
namespace {

struct Measured {
  double ms;
  std::string hash;
};
using Row = std::function<Measured()>;

template <class Item>
std::string hash_of(const std::vector<Item>& items) {
  return sha256(
             std::string_view(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(items[0])))
      .hex()
      .substr(0, 16);
}

Row canonical(std::uint32_t points, const Execution& execution) {
  const std::vector<Vec3d> at = random_cube(points);
  Box box;
  for (const Vec3d& p : at) box.add(p);
  return [t = tetrahedralize(at, box, execution).value(), &execution] {
    Tetrahedralization mine = t;
    const double start = now_ms();
    canonicalize(mine, execution);
    const double ms = now_ms() - start;
    return Measured{ms, hash_of(mine.tets)};
  };
}

Row prepare(int triangles, const Execution& execution) {
  return [mesh = std::make_shared<const Mesh>(test::sphere_with(triangles)), &execution] {
    const double start = now_ms();
    const Solid solid = make_solid(mesh, {}, execution).value();
    const double ms = now_ms() - start;
    return Measured{ms, hash_of(solid.triangles)};
  };
}

Row giant(std::uint32_t sites, const Execution& execution) {
  return [mesh = std::make_shared<const Mesh>(test::sphere_with(20'000)), sites, &execution] {
    FractureParameters parameters;
    parameters.sites = sites;
    parameters.hulls = Hulls::kConvex;
    StageTimings timings;
    const double start = now_ms();
    const Solid solid = make_solid(mesh, {}, execution).value();
    const Diagram diagram = make_diagram(solid, parameters, execution, timings).value();
    const auto glb = write_glb(fracture(solid, diagram, parameters, execution, timings).value(), {});
    const double ms = now_ms() - start;
    return Measured{ms, hash_of(glb)};
  };
}

Row row(const std::string& name, const Execution& execution) {
  if (name == "canonical_100k") return canonical(100'000, execution);
  if (name == "prepare_1M") return prepare(1'000'000, execution);
  if (name == "prepare_4M") return prepare(4'000'000, execution);
  if (name == "giant_100k") return giant(100'000, execution);
  std::fprintf(stderr, "no such stage: %s\n", name.c_str());
  std::exit(2);
}

int main_of(int argc, char** argv) {
  Execution execution;
  int runs = 3;
  std::vector<std::string> names;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--threads") == 0 && i + 1 < argc)
      execution.threads = std::max(1, std::atoi(argv[++i]));
    else if (std::strcmp(argv[i], "--runs") == 0 && i + 1 < argc)
      runs = std::max(1, std::atoi(argv[++i]));
    else
      names.emplace_back(argv[i]);
  }
  for (const std::string& name : names) {
    const Row measure = row(name, execution);
    Measured least = measure();
    for (int run = 1; run < runs; ++run) {
      const Measured again = measure();
      if (again.hash != least.hash) {
        std::printf("%s: two runs gave different answers\n", name.c_str());
        return 1;
      }
      least.ms = std::min(least.ms, again.ms);
    }
    std::printf("%-16s %10.3f ms  hash %s\n", name.c_str(), least.ms, least.hash.c_str());
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace fracture::bench

int main(int argc, char** argv) { return fracture::bench::main_of(argc, argv); }
