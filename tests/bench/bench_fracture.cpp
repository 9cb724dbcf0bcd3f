// Times the whole fracture of a mesh in memory, stage by stage: make_solid, make_diagram (sites +
// tetrahedralization), fracture.
//
//   bench_fracture [--out FOLDER] [--threads T] [--filter TEXT] [--only WORKLOAD] [--seconds S] [--hulls yes]
//
// Prints one line per workload: the median milliseconds in total and by stage, the least time for a prepared
// mesh (as a server keeps it), the fragments, the relative volume error, and a hash of all fragments. The
// program fails unless each repetition gives the same hash, a closed certificate and the volume to 1e-9. With
// --out each workload is also written, with its cells, for the peer (tests/bench/manifold/fracture.mjs).
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "common/digest/digest.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/bench/peer_cells.hpp"
#include "tests/bench/stopwatch.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::bench {
namespace {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

std::string hash_of(const FragmentSet& set, const CollisionHulls& hulls) {
  std::string bytes;
  const auto append = [&bytes](const auto& items) {
    if (!items.empty())
      bytes.append(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(items[0]));
  };
  for (const Fragment& f : set.fragments) {
    append(f.positions);
    append(f.indices);
    append(f.attributes.normals);
    bytes.append(reinterpret_cast<const char*>(&f.pivot), sizeof f.pivot);
  }
  for (const FragmentHulls& of : hulls.of_fragment)
    for (const CollisionHull& hull : of.hulls) {
      append(hull.points);
      append(hull.triangles);
    }
  return sha256(bytes).hex().substr(0, 16);
}

// -- workloads

struct Options {
  std::string out, filter, only;
  int threads = 1;
  double seconds = 1;
  bool hulls = false;
};

/// Returns false if an answer is wrong.
bool run(const std::string& name, const std::shared_ptr<const Mesh>& mesh, std::uint32_t sites,
         const Options& options, nlohmann::json& results) {
  Execution execution;
  execution.threads = options.threads;
  FractureParameters parameters;
  parameters.sites = sites;
  if (options.hulls) parameters.hulls = Hulls::kConvex;
  std::vector<double> whole, prepared, solid_ms, diagram_ms, fracture_ms;
  std::string hash;
  FragmentSet set;
  Solid solid;
  Diagram diagram;
  const double begin = now_ms();
  do {
    StageTimings timings;
    const double t0 = now_ms();
    Expected<Solid> s = make_solid(mesh, {}, execution);
    const double t1 = now_ms();
    Expected<Diagram> d =
        s ? make_diagram(*s, parameters, execution, timings) : Expected<Diagram>(tl::unexpected(s.error()));
    const double t2 = now_ms();
    Expected<FracturedSolid> f = d ? fracture(*s, *d, parameters, execution, timings)
                                   : Expected<FracturedSolid>(tl::unexpected(d.error()));
    const double t3 = now_ms();
    if (!f) {
      std::printf("%-12s %5u sites: %s: %s\n", name.c_str(), sites, slug(f.error().code),
                  f.error().detail.c_str());
      return false;
    }
    whole.push_back(t3 - t0);
    prepared.push_back(t3 - t1);
    solid_ms.push_back(t1 - t0);
    diagram_ms.push_back(t2 - t1);
    fracture_ms.push_back(t3 - t2);
    const std::string h = hash_of(f->set, f->hulls);
    if (!hash.empty() && h != hash) {
      std::printf("%s, %u sites: two runs gave different fragments\n", name.c_str(), sites);
      return false;
    }
    hash = h;
    solid = std::move(*s);
    diagram = std::move(*d);
    set = std::move(f->set);
  } while (whole.size() < 3 || (now_ms() - begin < 1000 * options.seconds && whole.size() < 101));
  const Certificate& c = set.certificate;
  const bool right = c.open_edges == 0 && c.relative_error <= 1e-9 && !set.fragments.empty();
  std::printf(
      "%-12s %6zu triangles %5u sites %s hulls: %9.3f ms, of a prepared mesh at least %.3f (solid %.3f, sites+delaunay %.3f, "
      "fracture %.3f) %5zu fragments, volume error %.1e, %s%s\n",
      name.c_str(), mesh->triangles.size(), sites, options.hulls ? "with" : "without", median(whole),
      *std::min_element(prepared.begin(), prepared.end()), median(solid_ms), median(diagram_ms),
      median(fracture_ms), set.fragments.size(), c.relative_error, hash.c_str(), right ? "" : " WRONG");
  std::fflush(stdout);
  if (!options.out.empty()) {
    const std::string file = name + "_" + std::to_string(sites) + ".bin";
    write_for_peer((std::filesystem::path(options.out) / file).string(), solid, diagram.tetrahedralization);
    results.push_back({{"name", name},
                       {"file", file},
                       {"triangles", mesh->triangles.size()},
                       {"sites", sites},
                       {"fragments", set.fragments.size()},
                       {"volume", solid.report.volume},
                       {"milliseconds", median(whole)},
                       {"hash", hash}});
  }
  return right;
}

Expected<Mesh> read(const std::string& name) {
  const auto file = test::find_test_mesh(name);
  return file ? test::read_obj_positions(file->path) : fail(ErrorCode::kEmptyBody, "absent");
}

int main_of(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--out") == 0) options.out = argv[i + 1];
    if (std::strcmp(argv[i], "--filter") == 0) options.filter = argv[i + 1];
    if (std::strcmp(argv[i], "--only") == 0) options.only = argv[i + 1];
    if (std::strcmp(argv[i], "--threads") == 0)
      options.threads = std::max(1, static_cast<int>(std::strtol(argv[i + 1], nullptr, 10)));
    if (std::strcmp(argv[i], "--hulls") == 0) options.hulls = std::strcmp(argv[i + 1], "yes") == 0;
    if (std::strcmp(argv[i], "--seconds") == 0) options.seconds = std::strtod(argv[i + 1], nullptr);
  }
  if (!options.out.empty()) std::filesystem::create_directories(options.out);
  const std::vector<std::pair<std::string, std::function<Expected<Mesh>()>>> meshes{
      {"sphere2k", [] { return test::sphere_with(2000); }},
      {"sphere20k", [] { return test::sphere_with(20000); }},
      {"torus", [] { return test::torus(96, 48); }},
      {"torus2k", [] { return test::torus(48, 24); }},
      {"hammer", [] { return read("hammer.obj"); }},
      {"penguin", [] { return read("penguin.obj"); }},
      {"spot", [] { return read("spot.obj"); }}};
  nlohmann::json results = nlohmann::json::array();
  bool right = true;
  for (const auto& [name, make] : meshes) {
    std::shared_ptr<const Mesh> mesh;
    for (const std::uint32_t sites : {10u, 50u, 200u, 1000u}) {
      const std::string label = name + "_" + std::to_string(sites);
      if (label.find(options.filter) == std::string::npos) continue;
      if (!options.only.empty() && label != options.only) continue;
      if (!mesh) {
        Expected<Mesh> made = make();
        if (!made) {
          std::printf("%s is absent: not measured\n", name.c_str());
          break;
        }
        mesh = std::make_shared<const Mesh>(std::move(*made));
      }
      right &= run(name, mesh, sites, options, results);
    }
  }
  if (!options.out.empty())
    std::ofstream(std::filesystem::path(options.out) / "workloads.json") << results.dump(1) << '\n';
  return right ? 0 : 1;
}

}  // namespace
}  // namespace fracture::bench

int main(int argc, char** argv) { return fracture::bench::main_of(argc, argv); }
