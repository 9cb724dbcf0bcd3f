// The pipeline in your own program: example MESH.obj FRAGMENTS.glb
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <string>

#include "common/gltf/gltf_writer.hpp"
#include "common/import/import.hpp"
#include "common/pipeline/fracture.hpp"

int main(int count, char** arguments) {
  using namespace fracture;
  if (count != 3) return std::fputs("usage: example MESH.obj FRAGMENTS.glb\n", stderr), 2;
  const auto refused = [](const Error& error) {
    return std::fprintf(stderr, "%s\n", error.detail.c_str()), 3;
  };

  std::ifstream file(arguments[1], std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  Expected<Mesh> mesh = import_mesh(std::as_bytes(std::span(bytes)), MeshFormat::kObj, {});
  if (!mesh) return refused(mesh.error());

  const Execution execution{.threads = 2};  // does not affect the bytes
  StageTimings timings;
  FractureParameters parameters;
  parameters.sites = 20;
  parameters.seed = 7;

  const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(std::move(*mesh)), {}, execution);
  if (!solid) return refused(solid.error());
  const Expected<Diagram> diagram = make_diagram(*solid, parameters, execution, timings);
  if (!diagram) return refused(diagram.error());
  const Expected<FracturedSolid> made = fracture::fracture(*solid, *diagram, parameters, execution, timings);
  if (!made) return refused(made.error());

  const auto glb = write_glb(*made, {}, execution);
  std::ofstream(arguments[2], std::ios::binary)
      .write(reinterpret_cast<const char*>(glb.data()), static_cast<std::streamsize>(glb.size()));
  const FragmentSet& set = made->set;
  std::printf("%zu fragments, volume %.9g of %.9g m3\n", set.fragments.size(), set.certificate.volume_out,
              set.certificate.volume_in);
}
