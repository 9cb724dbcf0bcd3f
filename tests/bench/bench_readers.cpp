// Times the reading of a mesh file by our reader and by Assimp.
//
//   bench_readers [--runs N] NAME...
//
//   obj_1M    an OBJ of a sphere with a million triangles, texture coordinates and normals
//
// The file is made in memory, and read until it is a Mesh. Prints one line for each reader: the shortest time of N runs in
// milliseconds (default 3). Both must find the same triangles, corner by corner, within the rounding of Assimp's numbers.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/import/assimp_import.hpp"
#include "common/import/obj_import.hpp"
#include "tests/bench/stopwatch.hpp"
#include "tests/import/make_files.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::bench {
namespace {

void write_number(std::string& text, float value) {
  char digits[32];
  text += ' ';
  text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

std::string sphere_obj(int triangles) {
  const Mesh mesh = test::sphere_with(triangles);
  std::string text = "o sphere\n";
  for (const Vec3f& p : mesh.positions) {
    text += 'v';
    for (const float value : {p.x, p.y, p.z}) write_number(text, value);
    text += "\nvt";
    for (const float value : {0.5f + 0.5f * p.x, 0.5f + 0.5f * p.y}) write_number(text, value);
    text += "\nvn";
    for (const float value : {p.x, p.y, p.z}) write_number(text, value);
    text += '\n';
  }
  for (const auto& t : mesh.triangles) {
    text += 'f';
    for (const std::uint32_t wedge : t) {
      const std::string number = std::to_string(wedge + 1);
      text += ' ' + number + '/' + number + '/' + number;
    }
    text += '\n';
  }
  return text;
}

using Corners = std::vector<Vec3f>;  ///< three for each triangle

using Reader = std::function<Expected<Mesh>(std::span<const std::byte>)>;

Corners timed(const std::string& text, const Reader& reader, double& ms) {
  const double start = now_ms();
  const Expected<Mesh> mesh = reader(test::bytes_of(text));
  ms = std::min(ms, now_ms() - start);
  Corners corners;
  if (mesh)
    for (const auto& t : mesh->triangles)
      for (const std::uint32_t wedge : t) corners.push_back(mesh->positions[wedge]);
  return corners;
}

Corners ours(const std::string& text, double& ms) {
  return timed(
      text, [](std::span<const std::byte> bytes) { return import_obj(bytes, {}, {}); }, ms);
}

Corners assimps(const std::string& text, double& ms) {
  return timed(
      text,
      [](std::span<const std::byte> bytes) { return import_with_assimp(bytes, MeshFormat::kObj, {}, {}); },
      ms);
}

bool alike(const Corners& a, const Corners& b) {
  constexpr float kTolerance = 1e-6f;  // in a sphere of radius 1
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(), [](const Vec3f& p, const Vec3f& q) {
           return std::fabs(p.x - q.x) < kTolerance && std::fabs(p.y - q.y) < kTolerance &&
                  std::fabs(p.z - q.z) < kTolerance;
         });
}

int main_of(int argc, char** argv) {
  int runs = 3;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--runs" && i + 1 < argc) {
      runs = std::max(1, std::atoi(argv[++i]));
      continue;
    }
    if (name != "obj_1M") return std::fprintf(stderr, "no such file: %s\n", name.c_str()), 2;
    const std::string text = sphere_obj(1'000'000);
    double our_ms = HUGE_VAL, assimp_ms = HUGE_VAL;
    for (int run = 0; run < runs; ++run) {
      const Corners mine = ours(text, our_ms);
      if (mine.empty() || !alike(mine, assimps(text, assimp_ms)))
        return std::printf("%s: the readers found different triangles\n", name.c_str()), 1;
    }
    std::printf("%-16s %10.3f ms, %zu bytes\n%-16s %10.3f ms\n", name.c_str(), our_ms, text.size(),
                (name + "_assimp").c_str(), assimp_ms);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace fracture::bench

int main(int argc, char** argv) { return fracture::bench::main_of(argc, argv); }
