// Compares rough cuts and fragments of six cells with flat cuts and one cell: the total of make_diagram() and
// fracture() with hulls.
//
//   bench_rough [--repeat N] [--sites N] [FILE]
//
// FILE is a mesh; default: a sphere of 2k triangles. Default: 50 cells. For each material with rough cuts,
// its roughness is applied to uniform cells. The result is the fastest of N runs (default 15), flat and rough
// in turn in one process with one thread.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/materials/materials.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/bench/stopwatch.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::bench {
namespace {

struct Run {
  double ms = 1e9;
  std::size_t triangles = 0;
  std::uint64_t calmed = 0;
};

void fracture_once(const Solid& solid, const FractureParameters& p, Run& run) {
  const Execution execution;
  StageTimings timings;
  const double start = now_ms();
  const Expected<Diagram> diagram = make_diagram(solid, p, execution, timings);
  const Expected<FracturedSolid> made = fracture(solid, *diagram, p, execution, timings);
  run.ms = std::min(run.ms, now_ms() - start);
  run.triangles = 0;
  for (const Fragment& f : made->set.fragments) run.triangles += f.indices.size() / 3;
  if (made->report.rough_cuts) run.calmed = made->report.rough_cuts->calmed_vertices;
}

int run(int repeat, std::uint32_t sites, const std::string& file) {
  Expected<Mesh> mesh =
      file.empty() ? Expected<Mesh>(test::sphere_with(2000)) : test::load_mesh({file, file});
  if (!mesh) return std::puts(mesh.error().detail.c_str()), 1;
  const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(std::move(*mesh)), {}, {});
  if (!solid) return std::puts(solid.error().detail.c_str()), 1;
  FractureParameters flat;
  flat.sites = sites;
  flat.hulls = Hulls::kConvex;
  const auto compare = [&](const std::string& name, const FractureParameters& other) {
    Run without, with;
    for (int k = 0; k < repeat; ++k) {
      fracture_once(*solid, flat, without);
      fracture_once(*solid, other, with);
    }
    std::printf(
        "%-10s %6.2f ms, %6zu triangles, %llu vertices calmed; %.1f times as long as flat, %.2f ms, %zu triangles\n",
        name.c_str(), with.ms, with.triangles, static_cast<unsigned long long>(with.calmed),
        with.ms / without.ms, without.ms, without.triangles);
  };
  FractureParameters aggregates = flat;
  aggregates.aggregation.cells = 6;
  compare("six cells", aggregates);
  for (const MaterialPreset& preset : material_presets()) {
    if (!(preset.roughness.amplitude > 0)) continue;
    FractureParameters rough = flat;
    rough.roughness = preset.roughness;
    compare(std::string(preset.name), rough);
  }
  return 0;
}

}  // namespace
}  // namespace fracture::bench

int main(int argc, char** argv) {
  int repeat = 15, sites = 50;
  std::string file;
  for (int k = 1; k < argc; ++k) {
    const std::string argument = argv[k];
    if (argument == "--repeat" && k + 1 < argc)
      repeat = std::atoi(argv[++k]);
    else if (argument == "--sites" && k + 1 < argc)
      sites = std::atoi(argv[++k]);
    else
      file = argument;
  }
  return fracture::bench::run(repeat, static_cast<std::uint32_t>(sites), file);
}
