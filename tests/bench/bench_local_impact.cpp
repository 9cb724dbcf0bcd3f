// Compares a hit on a fractured mesh with the same answer computed from scratch.
//
//   bench_local_impact [--repeat N] [--triangles N] [--sites N] [--new N] [--hulls 0|1] [--rough PERCENT]
//
// The mesh is a sphere (20k triangles) with 300 cells, and a hit with 30 cells at its side. Each step is
// run N times (default 15), in turn in one process, and the fastest run counts. The steps are make_solid(),
// make_diagram() and fracture() with the hit, and fracture_delta() on the stored answer without it. The last is run
// once for the whole answer and once for only the new and changed parts. Writing each answer as a GLB is timed as
// well. With --rough the cuts have an amplitude of this percentage of the size and the waviness of stone. The
// program fails if the two answers differ in a bit of a position, an index or a volume.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "common/gltf/gltf_writer.hpp"
#include "common/hits/delta.hpp"
#include "tests/bench/stopwatch.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::bench {
namespace {

struct Least {
  double ms = 1e9;
  template <class Work>
  auto time(const Work& work) {
    const double start = now_ms();
    auto result = work();
    ms = std::min(ms, now_ms() - start);
    return result;
  }
};

bool same(const FragmentSet& a, const FragmentSet& b) {
  return std::equal(a.fragments.begin(), a.fragments.end(), b.fragments.begin(), b.fragments.end(),
                    [](const Fragment& x, const Fragment& y) {
                      return x.id == y.id && x.positions == y.positions && x.indices == y.indices &&
                             x.mass.volume == y.mass.volume;
                    });
}

struct Options {
  int repeat = 15, triangles = 20000, sites = 300, further = 30, hulls = 1;  // hulls = 0: only without hulls
  int rough = 0;
};

int run(const Options& options, Hulls hulls) {
  const Execution execution;
  StageTimings timings;
  const auto mesh = std::make_shared<Mesh>(test::sphere_with(options.triangles));
  const Expected<Solid> solid = make_solid(mesh, {}, execution);
  FractureParameters p;
  p.sites = static_cast<std::uint32_t>(options.sites);
  p.hulls = hulls;
  p.rest = LocalRest::kFractured;
  p.roughness = {options.rough / 100.0, 4, 2};
  // With more than a thousand cells the radius shrinks with the cells, so that the hit touches about as many
  // of them.
  const double radius = 0.3 * std::fmin(1, std::cbrt(1000.0 / options.sites));
  p.hits = {{{1, 0, 0}, radius, static_cast<std::uint32_t>(options.further)}};
  const Expected<KeptAnswer> base = fracture_and_keep(*solid, before_hits(p, 1), execution, timings);
  if (!base) return 1;
  Least prepare, whole, local, changed_only, whole_file, local_file;
  std::size_t fragments = 0, added = 0, changed = 0, gone = 0, whole_bytes = 0, local_bytes = 0;
  for (int k = 0; k < options.repeat; ++k) {
    if (!prepare.time([&] { return make_solid(mesh, {}, execution); })) return 1;
    const Expected<FracturedSolid> all = whole.time([&]() -> Expected<FracturedSolid> {
      const Expected<Diagram> diagram = make_diagram(*solid, p, execution, timings);
      if (!diagram) return tl::unexpected(diagram.error());
      return fracture(*solid, *diagram, p, execution, timings);
    });
    if (!all) {
      std::printf("%s: %s\n", slug(all.error().code), all.error().detail.c_str());
      return 1;
    }
    Expected<KeptAnswer> hit =
        local.time([&] { return fracture_delta(*solid, base->base, p, {1}, execution, timings); });
    if (!hit || !same(all->set, hit->fractured.set)) {
      std::printf("the answers differ\n");
      return 1;
    }
    const Expected<KeptAnswer> part = changed_only.time([&] {
      return fracture_delta(*solid, base->base, p, {1, true}, execution, timings);
    });
    if (!part) return 1;
    fragments = all->set.fragments.size();
    added = hit->fractured.delta->added.size();
    changed = hit->fractured.delta->changed.size();
    gone = hit->fractured.delta->gone.size();
    whole_bytes = whole_file.time([&] { return write_glb(*all, {}); }).size();
    local_bytes = local_file.time([&] { return write_glb(part->fractured, {}); }).size();
  }
  const auto times = [&](double from_nothing, double of_a_hit) {
    std::printf("; %.1f times as fast as the whole, %.1f with the mesh's preparation\n",
                from_nothing / of_a_hit, (prepare.ms + from_nothing) / of_a_hit);
  };
  std::printf("%s hulls: %zu fragments, %zu new, %zu changed, %zu gone; preparation %.2f ms, whole %.2f ms\n",
              hulls == Hulls::kNone ? "without" : "with", fragments, added, changed, gone, prepare.ms,
              whole.ms);
  std::printf("  a hit %.2f ms", local.ms);
  times(whole.ms, local.ms);
  std::printf("  without the untouched %.2f ms", changed_only.ms);
  times(whole.ms, changed_only.ms);
  const double hit_and_file = changed_only.ms + local_file.ms;
  std::printf("  and its GLB %.2f ms, %zu bytes (whole: %.2f ms, %zu bytes)", hit_and_file, local_bytes,
              whole.ms + whole_file.ms, whole_bytes);
  times(whole.ms + whole_file.ms, hit_and_file);
  return 0;
}

}  // namespace
}  // namespace fracture::bench

int main(int argc, char** argv) {
  using namespace fracture::bench;
  Options options;
  for (int k = 1; k + 1 < argc; k += 2)
    for (const auto& [name, value] : {std::pair{"--repeat", &options.repeat},
                                      {"--triangles", &options.triangles},
                                      {"--sites", &options.sites},
                                      {"--new", &options.further},
                                      {"--hulls", &options.hulls},
                                      {"--rough", &options.rough}})
      if (std::strcmp(argv[k], name) == 0) *value = std::atoi(argv[k + 1]);
  const int without = run(options, fracture::Hulls::kNone);
  return without + (options.hulls ? run(options, fracture::Hulls::kConvex) : 0);
}
