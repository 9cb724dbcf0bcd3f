// Compares fragments of several cells with convex fragments: equal numbers of both, for stone and concrete.
//
//   bench_aggregates [--repeat N] [--fragments N] [FILE]
//
// FILE is a mesh; default: the monkey of assimp-testmodels. Default: 50 fragments. The result is the least
// processor time in milliseconds over N runs (default 30) of make_diagram() and fracture() on a prepared mesh
// with one thread. All variants run in turn in one process: with and without hulls, with the material's
// roughness and with flat cuts. "convex": the material's pattern with one cell for each fragment.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/base/processor_time.hpp"
#include "common/materials/materials.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/support/mesh_files.hpp"

namespace fracture::bench {
namespace {

struct Run {
  const char* name;
  FractureParameters parameters;
  double ms = 1e9;
  std::size_t fragments = 0, triangles = 0;
  std::uint32_t hulls = 0;
};

void fracture_once(const Solid& solid, Run& run) {
  const Execution execution;
  StageTimings timings;
  const double start = processor_seconds_of_this_thread();
  const Expected<Diagram> diagram = make_diagram(solid, run.parameters, execution, timings);
  const Expected<FracturedSolid> made = fracture(solid, *diagram, run.parameters, execution, timings);
  run.ms = std::min(run.ms, 1000 * (processor_seconds_of_this_thread() - start));
  run.fragments = made->set.fragments.size();
  run.hulls = made->hulls.report().hulls;
  run.triangles = 0;
  for (const Fragment& f : made->set.fragments) run.triangles += f.indices.size() / 3;
}

int run(int repeat, std::uint32_t fragments, const std::string& file) {
  const auto monkey = test::assimp_model("BLEND/Suzanne_248.blend");
  if (file.empty() && !monkey) return std::puts("no monkey: name a mesh"), 1;
  Expected<Mesh> mesh = test::load_mesh(file.empty() ? *monkey : test::MeshFile{file, file});
  if (!mesh) return std::puts(mesh.error().detail.c_str()), 1;
  const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(std::move(*mesh)), {}, {});
  if (!solid) return std::puts(solid.error().detail.c_str()), 1;
  for (const char* material : {"stone", "concrete"}) {
    const MaterialPreset& preset = *find_material_preset(material);
    FractureParameters p;
    p.sites = fragments;
    p.pattern = preset.pattern;
    p.lloyd = preset.lloyd;
    p.aggregation = preset.aggregation;
    p.size.fragments = fragments;
    p.size.min_of_mean = kLeastOfMean;
    std::vector<Run> runs;
    const auto add = [&](const char* name, bool convex, bool rough, Hulls hulls) {
      Run& made = runs.emplace_back(Run{name, p});
      if (convex) made.parameters.aggregation = {};
      if (rough) made.parameters.roughness = preset.roughness;
      made.parameters.hulls = hulls;
    };
    add("convex, flat, without hulls", true, false, Hulls::kNone);
    add("convex, flat", true, false, Hulls::kConvex);
    add("convex, rough", true, true, Hulls::kConvex);
    add("ragged, flat, without hulls", false, false, Hulls::kNone);
    add("ragged, flat", false, false, Hulls::kConvex);
    add("ragged, rough", false, true, Hulls::kConvex);
    for (int k = 0; k < repeat; ++k)
      for (Run& each : runs) fracture_once(*solid, each);
    for (const Run& each : runs)
      std::printf("%-9s %-28s %7.2f ms, %4zu fragments, %6zu triangles, %5u hulls\n", material, each.name,
                  each.ms, each.fragments, each.triangles, each.hulls);
  }
  return 0;
}

}  // namespace
}  // namespace fracture::bench

int main(int argc, char** argv) {
  int repeat = 30, fragments = 50;
  std::string file;
  for (int k = 1; k < argc; ++k) {
    const std::string argument = argv[k];
    if (argument == "--repeat" && k + 1 < argc)
      repeat = std::atoi(argv[++k]);
    else if (argument == "--fragments" && k + 1 < argc)
      fragments = std::atoi(argv[++k]);
    else
      file = argument;
  }
  return fracture::bench::run(repeat, static_cast<std::uint32_t>(fragments), file);
}
