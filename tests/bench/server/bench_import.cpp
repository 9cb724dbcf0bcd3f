// Measures the cost of import workers: the same file is read in this process and by a worker of a pool.
//
//   bench_import [--repeat N] [--workers N] [FILE...]
//
// Without files it uses a sphere of 1k triangles as OBJ and as GLB. Prints the least and the median of N
// imports (default 300), one after the other. `at once` has no pause, so the pool must make its next worker
// meanwhile. `rested` pauses for 5 ms between imports, like a server that also fractures the meshes.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "common/digest/digest.hpp"
#include "server/import_worker/import_pool.hpp"
#include "server/import_worker/mesh_codec.hpp"
#include "tests/bench/stopwatch.hpp"
#include "tests/import/make_files.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::bench {
namespace {

struct Input {
  std::string name, bytes;
  MeshFormat format;
};

std::string as_obj(const Mesh& mesh) {
  std::string obj;
  for (const Vec3f& p : mesh.positions)
    obj += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
  for (const auto& t : mesh.triangles)
    obj += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) +
           "\n";
  return obj;
}

std::string as_glb(const Mesh& mesh) {
  std::string positions, indices;
  for (const Vec3f& p : mesh.positions) test::put<float>(positions, {p.x, p.y, p.z});
  for (const auto& t : mesh.triangles) test::put<std::uint32_t>(indices, {t[0], t[1], t[2]});
  constexpr int kFloat = 5126, kUnsigned = 5125;  // glTF 2.0, section 3.6.2.2
  test::Tetrahedron file;
  file.primitive()["attributes"]["POSITION"] =
      file.add_accessor(positions, kFloat, mesh.positions.size(), "VEC3");
  file.primitive()["indices"] = file.add_accessor(indices, kUnsigned, 3 * mesh.triangles.size(), "SCALAR");
  return file.glb();
}

void report(const char* how, int repeat, std::chrono::milliseconds rest,
            const std::function<Expected<Mesh>()>& import, const std::vector<std::byte>& right) {
  std::vector<double> times;
  for (int k = 0; k < repeat; ++k) {
    std::this_thread::sleep_for(rest);
    const double start = now_ms();
    const Expected<Mesh> mesh = import();
    times.push_back(now_ms() - start);
    if (encode_reply(mesh) != right) std::puts("a wrong answer"), std::exit(1);
  }
  std::sort(times.begin(), times.end());
  std::printf("  %-18s least %6.3f ms, median %6.3f ms\n", how, times.front(), times[times.size() / 2]);
}

int run(int repeat, int workers, std::vector<Input> inputs) {
  if (inputs.empty()) {
    const Mesh sphere = test::sphere_with(1000);
    inputs = {{"sphere.obj", as_obj(sphere), MeshFormat::kObj},
              {"sphere.glb", as_glb(sphere), MeshFormat::kGlb}};
  }
  ImportPoolConfig config;
  config.worker.program = FRACTURE_IMPORT_PROGRAM;
  config.workers = workers;
  ImportPool pool(config);
  for (const Input& input : inputs) {
    const auto bytes = test::bytes_of(input.bytes);
    const auto here = [&] { return import_mesh(bytes, input.format, {}, {}); };
    const std::string digest = sha256(bytes).hex();
    const auto there = [&] { return pool.import(bytes, input.format, {}, {}, {}, digest); };
    const Expected<Mesh> mesh = here();
    if (!mesh) return std::puts(mesh.error().detail.c_str()), 1;
    const std::vector<std::byte> right = encode_reply(mesh);
    std::printf("%s: %zu bytes, %zu triangles\n", input.name.c_str(), input.bytes.size(),
                mesh->triangles.size());
    report("in process", repeat, {}, here, right);
    report("in workers, at once", repeat, {}, there, right);
    report("in workers, rested", repeat, std::chrono::milliseconds(5), there, right);
  }
  return 0;
}

}  // namespace
}  // namespace fracture::bench

int main(int argc, char** argv) {
  using namespace fracture;
  int repeat = 300, workers = 1;
  std::vector<bench::Input> inputs;
  for (int k = 1; k < argc; ++k) {
    const std::string argument = argv[k];
    if (argument == "--repeat" && k + 1 < argc) {
      repeat = std::max(1, std::atoi(argv[++k]));
    } else if (argument == "--workers" && k + 1 < argc) {
      workers = std::max(1, std::atoi(argv[++k]));
    } else {
      const std::filesystem::path path = argument;
      const auto format = format_from_extension(path.extension().string().substr(1));
      if (!format) return std::puts("bench_import: an unknown format"), 1;
      std::ifstream in(path, std::ios::binary);
      inputs.push_back({argument, {std::istreambuf_iterator<char>(in), {}}, *format});
    }
  }
  return bench::run(repeat, workers, std::move(inputs));
}
