// Prints one hash a line over the bytes of whole answers: `<mesh> <sites> <seed> <dual> t<threads> <sha256>`.
// scripts/test
// --full runs it in every build (g++ and clang++, debug and release) and compares the outputs; nothing is
// ever compared with a stored value. Exits 1 when one and two threads of the same build already differ.
#include <cstdio>
#include <string>
#include <vector>

#include "common/base/digest.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "common/pipeline/fracture.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"

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
  const Expected<FragmentSet> set = fracture::fracture(*solid, *diagram, parameters, execution, timings);
  if (!set) return std::string("refused: ") + slug(set.error().code);
  const std::vector<std::uint8_t> glb = write_glb(*set, {});
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
  for (const auto& [name, mesh] : meshes)
    for (const Dual dual : {Dual::kCircumcenter, Dual::kBarycenter})
      for (const std::uint32_t sites : {7u, 120u}) {
        if (dual == Dual::kBarycenter && (sites > 7 || mesh->triangles.size() > 3000))
          continue;  // cost: sites x triangles
        FractureParameters parameters;
        parameters.sites = sites;
        parameters.seed = 42;
        parameters.dual = dual;
        const std::string one = hash_of(mesh, parameters, 1), two = hash_of(mesh, parameters, 2);
        differing += one != two;
        const char* dual_name = dual == Dual::kCircumcenter ? "circumcenter" : "barycenter";
        std::printf("%s %u 42 %s t1 %s\n", name.c_str(), sites, dual_name, one.c_str());
        std::printf("%s %u 42 %s t2 %s\n", name.c_str(), sites, dual_name, two.c_str());
      }
  if (differing) std::fprintf(stderr, "%d answers differ between one and two threads\n", differing);
  return differing ? 1 : 0;
}
