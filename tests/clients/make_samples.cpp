// Writes the files that the judges look at: one made by hand, and fractures of generated and (where they are)
// real meshes.   usage: make_samples FOLDER
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "common/gltf/gltf_writer.hpp"
#include "tests/gltf/two_halves.hpp"
#ifdef FRACTURE_HAS_PIPELINE
#include "common/import/import.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"
#endif

namespace fracture::test {
namespace {

void write(const std::filesystem::path& path, const FragmentSet& set) {
  const std::vector<std::uint8_t> glb = write_glb(set, {});
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(glb.data()), static_cast<std::streamsize>(glb.size()));
}

#ifdef FRACTURE_HAS_PIPELINE
/// False where a stage refuses the mesh.
bool fracture_to(const std::filesystem::path& path, Mesh mesh, std::uint32_t sites) {
  StageTimings timings;
  const Execution execution;
  const Expected<Solid> solid = make_solid(std::make_shared<const Mesh>(std::move(mesh)), {}, execution);
  if (!solid) return false;
  FractureParameters parameters;
  parameters.sites = sites;
  const Expected<Diagram> diagram = make_diagram(*solid, parameters, execution, timings);
  if (!diagram) return false;
  const Expected<FragmentSet> set = fracture(*solid, *diagram, parameters, execution, timings);
  if (!set) return false;
  write(path, *set);
  return true;
}
#endif

int run(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  write(folder / "two_halves.glb", two_halves());
  int failures = 0;
#ifdef FRACTURE_HAS_PIPELINE
  const auto expect = [&failures](bool done, const std::string& name) {
    if (!done) std::printf("%s was not fractured\n", name.c_str());
    failures += !done;
  };
  expect(fracture_to(folder / "cube.glb", cube(), 50), "cube");
  expect(fracture_to(folder / "torus.glb", torus(48, 24), 50), "torus");
  expect(fracture_to(folder / "seams.glb", sphere_with_seams(24, 48), 100), "sphere with seams");
  expect(fracture_to(folder / "one.glb", cube(), 1), "cube in one piece");
  for (const std::string& name : closed_test_meshes()) {
    const auto file = find_test_mesh(name);
    if (!file) continue;
    const Expected<Mesh> mesh = load_mesh(*file);
    std::string flat = name + ".glb";
    for (char& c : flat) c = c == '/' ? '_' : c;
    expect(mesh && fracture_to(folder / flat, *mesh, 50), name);
  }
  if (const auto monkey = assimp_model("BLEND/Suzanne_248.blend")) {
    const Expected<Mesh> mesh = load_mesh(*monkey);
    expect(mesh && fracture_to(folder / "monkey.glb", *mesh, 50), "the monkey");
  }
#endif
  return failures == 0 ? 0 : 1;
}

}  // namespace
}  // namespace fracture::test

int main(int argc, char** argv) {
  if (argc != 2) {
    std::puts("usage: make_samples FOLDER");
    return 2;
  }
  return fracture::test::run(argv[1]);
}
