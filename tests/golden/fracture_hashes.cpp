// Prints one hash per line over the bytes of whole answers: `<mesh> <request> t<threads> <sha256>`. It makes
// plain requests and rough cuts on every mesh. On three meshes it also uses every pattern, material, limit,
// region and hit. `scripts/test --full` runs it in every build (g++ and clang++, debug and release) and
// compares the outputs. golden_bytes.py compares fewer answers with stored hashes. Exits with 1 if one and
// two threads of a build differ.
#include <cstdio>
#include <string>
#include <vector>

#include "common/digest/digest.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/pattern_requests.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/structure_requests.hpp"

namespace {

using namespace fracture;

std::string hash_of(const std::shared_ptr<const Mesh>& mesh, const FractureParameters& parameters,
                    int threads) {
  Execution execution;
  execution.threads = threads;
  StageTimings timings;
  const Expected<Solid> solid = make_solid(mesh, {}, execution);
  if (!solid) return std::string("refused: ") + slug(solid.error().code);
  const Expected<Diagram> diagram = make_diagram(*solid, parameters, execution, timings);
  if (!diagram) return std::string("refused: ") + slug(diagram.error().code);
  const Expected<FracturedSolid> made = fracture::fracture(*solid, *diagram, parameters, execution, timings);
  if (!made) return std::string("refused: ") + slug(made.error().code);
  GltfOptions options;
  options.interior = interior_materials({}, *solid).value();
  const std::vector<std::uint8_t> glb = write_glb(*made, options);
  return sha256(std::as_bytes(std::span(glb))).hex();
}

}  // namespace

int main() {
  std::vector<std::pair<std::string, std::shared_ptr<const Mesh>>> meshes;
  for (test::NamedMesh& shape : test::closed_shapes())
    meshes.emplace_back(shape.name, std::make_shared<Mesh>(std::move(shape.mesh)));
  for (const test::MeshFile& file : test::test_meshes())
    if (Expected<Mesh> mesh = test::load_mesh(file))
      meshes.emplace_back(file.name, std::make_shared<Mesh>(std::move(*mesh)));

  int differing = 0;
  const auto compare = [&](const std::string& name, const std::shared_ptr<const Mesh>& mesh,
                           const std::string& request, const FractureParameters& parameters) {
    const std::string one = hash_of(mesh, parameters, 1), two = hash_of(mesh, parameters, 2);
    differing += one != two;
    std::printf("%s %s t1 %s\n%s %s t2 %s\n", name.c_str(), request.c_str(), one.c_str(), name.c_str(),
                request.c_str(), two.c_str());
  };
  for (const auto& [name, mesh] : meshes)
    for (const Dual dual : {Dual::kCircumcenter, Dual::kBarycenter})
      for (const std::uint32_t sites : {7u, 120u}) {
        if (dual == Dual::kBarycenter && (sites > 7 || mesh->triangles.size() > 3000))
          continue;  // costs: sites x triangles
        FractureParameters parameters;
        parameters.sites = sites;
        parameters.seed = 42;
        parameters.dual = dual;
        compare(
            name, mesh,
            std::to_string(sites) + " 42 " + (dual == Dual::kCircumcenter ? "circumcenter" : "barycenter"),
            parameters);
      }
  for (const auto& [name, mesh] : meshes) {
    FractureParameters parameters;
    parameters.sites = 7;
    parameters.seed = 42;
    parameters.roughness = {0.04, 4, 2};
    compare(name, mesh, "7 42 rough", parameters);
  }
  for (const auto& [name, mesh] : meshes) {
    if (name != "uv_sphere" && name != "torus" && name != "kk_bottle_A_brown.glb") continue;
    const Expected<Solid> solid = make_solid(mesh, {}, {});
    if (!solid) continue;
    for (const auto& requests :
         {test::pattern_requests(solid->box, 90, 42), test::structure_requests(*solid, 90, 42)})
      for (const test::NamedParameters& request : requests)
        compare(name, mesh, request.name, request.parameters);
  }
  if (differing) std::fprintf(stderr, "%d answers differ between one and two threads\n", differing);
  return differing ? 1 : 0;
}
