// The points of the Delaunay benchmark, shared by our program and its peers so that all get identical
// coordinates. Also the little that these programs have in common: command line, repetition, output.
#pragma once

#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "common/base/random.hpp"
#include "common/base/vec.hpp"

namespace fracture::bench {

struct Workload {
  std::string name;
  std::vector<Vec3d> points;
  bool generic =
      true;  ///< no five cospherical points: the Delaunay tetrahedralization is unique without a tie rule
};

inline std::vector<Vec3d> random_cube(std::uint32_t n) {
  Random random(n);
  std::vector<Vec3d> points(n);
  for (Vec3d& p : points)
    for (int a = 0; a < 3; ++a) p[a] = random.uniform();
  return points;
}
inline std::vector<Vec3d> lattice22(double divisor) {
  std::vector<Vec3d> points;
  for (int x = 0; x < 22; ++x)
    for (int y = 0; y < 22; ++y)
      for (int z = 0; z < 22; ++z) points.push_back({x / divisor, y / divisor, z / divisor});
  return points;
}
inline std::vector<Vec3d> on_sphere(std::uint32_t n) {
  Random random(n);
  std::vector<Vec3d> points;
  while (points.size() < n) {
    Vec3d p;
    for (int a = 0; a < 3; ++a) p[a] = 2 * random.uniform() - 1;
    const double r = length(p);
    if (r <= 1 && r > 0.1) points.push_back({p.x / r, p.y / r, p.z / r});
  }
  return points;
}
/// Balls of radius 1e-3 around 100 random centres.
inline std::vector<Vec3d> clusters(std::uint32_t n) {
  Random random(n);
  const std::vector<Vec3d> centers = random_cube(100);
  std::vector<Vec3d> points(n);
  for (Vec3d& p : points) {
    const Vec3d& c = centers[random.below(centers.size())];
    for (int a = 0; a < 3; ++a) p[a] = c[a] + 1e-3 * (random.uniform() - 0.5);
  }
  return points;
}

inline std::vector<std::string> workload_names() {
  return {"random_100",     "random_1k",         "random_10k", "random_100k", "random_1M",
          "lattice22_21st", "lattice22_integer", "sphere_10k", "clusters_50k"};
}
inline Workload make_workload(const std::string& name) {
  if (name == "random_100") return {name, random_cube(100)};
  if (name == "random_1k") return {name, random_cube(1000)};
  if (name == "random_10k") return {name, random_cube(10'000)};
  if (name == "random_100k") return {name, random_cube(100'000)};
  if (name == "random_1M") return {name, random_cube(1'000'000)};
  if (name == "lattice22_21st") return {name, lattice22(21), false};
  if (name == "lattice22_integer") return {name, lattice22(1), false};
  if (name == "sphere_10k") return {name, on_sphere(10'000)};
  if (name == "clusters_50k") return {name, clusters(50'000)};
  std::fprintf(stderr, "no such workload: %s\n", name.c_str());
  std::exit(2);
}

/// A hash of a set of tetrahedra given by point indices (corners of the big tetrahedron: n..n+3), independent
/// of their order.
class TetSetHash {
 public:
  void add(std::array<std::uint32_t, 4> v) {
    std::sort(v.begin(), v.end());
    Random mix((static_cast<std::uint64_t>(v[0]) << 32 | v[1]) * kGoldenGamma ^
               (static_cast<std::uint64_t>(v[2]) << 32 | v[3]));
    sum_ += mix();
    ++count_;
  }
  std::uint64_t value() const { return sum_; }
  std::uint64_t count() const { return count_; }

 private:
  std::uint64_t sum_ = 0, count_ = 0;
};

/// Processor time of this process in milliseconds, user and system. All these programs have one thread, and
/// unlike wall time it excludes other programs on the same machine.
inline double cpu_milliseconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

/// Runs body() at least `least` times and for at least 0.3 s. Returns the best processor time in
/// milliseconds.
template <class Body>
double best_milliseconds(int least, Body body) {
  double best = HUGE_VAL, total = 0;
  for (int run = 0; run < least || total < 300; ++run) {
    const double start = cpu_milliseconds();
    body();
    const double ms = cpu_milliseconds() - start;
    best = std::min(best, ms);
    total += ms;
  }
  return best;
}

struct Arguments {
  std::vector<std::string> workloads;
  int runs = 3;
  bool check = false;  ///< print a hash of the answer
};
/// Parses [--runs N] [--check] [WORKLOAD...].
inline Arguments parse_arguments(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--runs") == 0 && i + 1 < argc)
      arguments.runs = static_cast<int>(std::strtol(argv[++i], nullptr, 10));
    else if (std::strcmp(argv[i], "--check") == 0)
      arguments.check = true;
    else
      arguments.workloads.emplace_back(argv[i]);
  }
  if (arguments.workloads.empty()) arguments.workloads = workload_names();
  return arguments;
}

/// Prints one line for people and for scripts/bench: name, points, milliseconds, tetrahedra, hash.
inline void print_result(const Workload& w, double ms, std::uint64_t tets, std::uint64_t hash) {
  std::printf("%-18s %8zu points %10.3f ms %9llu tets  hash %016llx\n", w.name.c_str(), w.points.size(), ms,
              static_cast<unsigned long long>(tets), static_cast<unsigned long long>(hash));
  std::fflush(stdout);
}

}  // namespace fracture::bench
