// Times tetrahedralize() on every workload. --method=flips times the insertions by the paper's flips instead.
// --check validates the structure by exact in_sphere (slow) and fails on a broken invariant.
#include <cstdio>

#include "common/delaunay/incremental.hpp"
#include "common/delaunay/spatial_order.hpp"
#include "common/delaunay/tetrahedralization.hpp"
#include "tests/bench/delaunay_workloads.hpp"

int main(int argc, char** argv) {
  using namespace fracture;
  const bench::Arguments arguments = bench::parse_arguments(argc, argv);
  bool correct = true;
  for (const std::string& name : arguments.workloads) {
    const bench::Workload w = bench::make_workload(name);
    Box box;
    for (const Vec3d& p : w.points) box.add(p);
    Tetrahedralization result;
    const double ms = bench::best_milliseconds(arguments.runs, [&] {
      result = {};
      result = tetrahedralize(w.points, box, {}).value();
    });
    bench::TetSetHash hash;
    for (const Tetrahedron& t : result.tets) hash.add(t.v);
    bench::print_result(w, ms, hash.count(), hash.value());

    if (arguments.check) {
      IncrementalDelaunay delaunay(big_tetrahedron(box));
      delaunay.reserve(w.points.size());
      const auto start = std::chrono::steady_clock::now();
      const std::vector<std::uint32_t> order = spatial_order(w.points);
      const std::chrono::duration<double, std::milli> sorted = std::chrono::steady_clock::now() - start;
      for (const std::uint32_t i : order) delaunay.insert(w.points[i]);
      const std::chrono::duration<double, std::milli> inserted = std::chrono::steady_clock::now() - start;
      const auto error = delaunay.validate();
      correct = correct && !error;
      const auto& c = delaunay.counters();
      std::printf(
          "  %s; order %.1f ms, insert %.1f ms; sphere tests %llu, exact %llu, ties %llu; walk %llu, exact "
          "%llu\n",
          error ? error->c_str() : "valid", sorted.count(), inserted.count() - sorted.count(),
          static_cast<unsigned long long>(c.sphere_tests), static_cast<unsigned long long>(c.in_sphere.exact),
          static_cast<unsigned long long>(c.in_sphere.ties), static_cast<unsigned long long>(c.walk_steps),
          static_cast<unsigned long long>(c.orient3d.exact));
    }
  }
  return correct ? 0 : 1;
}
