// Times tetrahedralize() on every workload. With --check it also times only the insertions by both methods,
// validates the structures with exact in_sphere tests, and fails on a broken invariant or a different set of
// tetrahedra.
#include <cstdio>

#include "common/delaunay/reference/reference_delaunay.hpp"
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
    for (const auto& [v, n] : result.tets) hash.add({v[0], v[1], v[2], v[3]});
    bench::print_result(w, ms, hash.count(), hash.value());
    // Identical results include the numbering. Compare this hash between compilers and builds.
    std::uint64_t numbering = 0;
    for (const Tetrahedron& t : result.tets)
      for (int k = 0; k < 4; ++k)
        numbering = Random(numbering ^ (static_cast<std::uint64_t>(t.v[k]) << 32 | t.n[k]))();
    if (arguments.check) std::printf("  numbering %016llx\n", static_cast<unsigned long long>(numbering));

    if (arguments.check) {
      const double start = bench::cpu_milliseconds();
      const std::vector<std::uint32_t> order = spatial_order(w.points);
      std::printf("  order %.1f ms\n", bench::cpu_milliseconds() - start);
      for (const bool flips : {false, true}) {
        ReferenceDelaunay delaunay(big_tetrahedron(box));
        delaunay.reserve(w.points.size());
        const double begin = bench::cpu_milliseconds();
        if (flips)
          for (const std::uint32_t i : order) delaunay.insert_by_flips(w.points[i]);
        else
          for (const std::uint32_t i : order) delaunay.insert(w.points[i]);
        const double inserted = bench::cpu_milliseconds() - begin;
        std::vector<SiteId> site_of_vertex(delaunay.vertex_end());
        for (std::size_t i = 0; i < order.size(); ++i) site_of_vertex[i + 4] = SiteId{order[i]};
        bench::TetSetHash again;
        for (const auto& [v, n] : delaunay.snapshot(site_of_vertex).tets) again.add({v[0], v[1], v[2], v[3]});
        const auto error = w.points.size() <= 100'000 ? delaunay.validate() : std::nullopt;
        const bool good = !error && again.value() == hash.value();
        correct = correct && good;
        const auto& c = delaunay.counters();
        std::printf(
            "  %s: insertion %.1f ms, %s; in_sphere %llu, exact %llu, ties %llu; created %llu; walk steps "
            "%llu, exact orient3d %llu\n",
            flips ? "flips " : "cavity", inserted,
            error  ? error->c_str()
            : good ? "valid"
                   : "WRONG SET",
            static_cast<unsigned long long>(c.sphere_tests),
            static_cast<unsigned long long>(c.in_sphere.exact),
            static_cast<unsigned long long>(c.in_sphere.ties),
            static_cast<unsigned long long>(c.tets_created), static_cast<unsigned long long>(c.walk_steps),
            static_cast<unsigned long long>(c.orient3d.exact));
      }
    }
  }
  return correct ? 0 : 1;
}
