// The estimate of an answer, compared with the answers that are made: real meshes with every material.
#include "server/service/estimate.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "common/base/product.hpp"
#include "common/import/formats.hpp"
#include "server/service/service.hpp"
#include "tests/server/support/engine_in_process.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/mesh_files.hpp"

namespace fracture::test {
namespace {

struct Case {
  const char *mesh, *parameters;
};

/// Every material, meshes of 4 to 70,000 triangles, walls and sheets, flat and rough cuts, one cell and several for each fragment.
constexpr Case kCases[] = {
    {"suzanne.obj", "material=stone&fragments=60"},
    {"suzanne.obj", "material=stone&fragments=60&rough_amplitude=0"},
    {"spot.obj", "material=glass&fragments=80"},
    {"kk_barrel_large.glb", "material=wood&fragments=60"},
    {"kk_wall.glb", "material=brick&fragments=80"},
    {"kk_column.glb", "material=sandstone&fragments=40"},
    {"kk_chest.glb", "material=metal&fragments=30"},
    {"kk_bottle_A_brown.glb", "material=ceramic&fragments=60"},
    {"hammer.obj", "material=cast_iron&fragments=25"},
    {"torus.obj", "material=ice&fragments=50"},
    {"penguin.obj", "material=plaster&fragments=100"},
    {"cube.glb", "material=concrete&fragments=200"},
    {"round.stl", "material=crystal&fragments=40"},
    {"spot.obj", "material=terracotta&fragments=40"},
    {"kk_box_large.glb", "sites=2000"},
    {"FlightHelmet/FlightHelmet.gltf", "sites=50"},
    {"mountain_open.obj", "sites=300"},
    {"cube.glb", "sites=20"},
    {"suzanne.obj", "pattern=grid&fragments=60"},
};

std::vector<RawParameter> parameters_of(std::string_view text) {
  std::vector<RawParameter> parameters;
  while (!text.empty()) {
    const std::string_view one = text.substr(0, text.find('&'));
    const std::size_t equals = one.find('=');
    parameters.push_back({std::string(one.substr(0, equals)), std::string(one.substr(equals + 1))});
    text.remove_prefix(std::min(text.size(), one.size() + 1));
  }
  return parameters;
}

struct Read {
  std::string bytes;
  std::vector<std::pair<std::string, std::string>> files;
};

Read read(const MeshFile& file) {
  const auto bytes = [](const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  Read result{bytes(file.path), {}};
  const std::string folder = file.path.substr(0, file.path.rfind('/') + 1);
  if (file.path.ends_with(".gltf")) {
    const nlohmann::json document = nlohmann::json::parse(result.bytes);
    for (const char* list : {"buffers", "images"})
      for (const nlohmann::json& each : document.value(list, nlohmann::json::array()))
        if (each.contains("uri")) {
          const auto name = each["uri"].get<std::string>();
          result.files.emplace_back(name, bytes(folder + name));
        }
  }
  return result;
}

bool near(double expected, double made, double factor = kEstimateFactor) {
  return expected <= factor * made && made <= factor * expected;
}

TEST(Estimate, IsWithinAFactorOfTwoOfWhatIsMade) {
  std::size_t compared = 0;
  for (const Case& c : kCases) {
    if (short_tests() && compared >= 4) break;
    const auto file = find_test_mesh(c.mesh);
    if (!file) continue;
    SCOPED_TRACE(std::string(c.mesh) + " " + c.parameters);
    const Read mesh = read(*file);
    FractureService service({}, engine_in_process());
    FractureRequest request;
    request.mesh = std::as_bytes(std::span(mesh.bytes.data(), mesh.bytes.size()));
    request.format = *format_from_extension(file->name.substr(file->name.rfind('.') + 1));
    for (const auto& [name, bytes] : mesh.files)
      request.files.push_back({name, std::as_bytes(std::span(bytes.data(), bytes.size()))});
    const auto asked = service.parameters().parse(parameters_of(c.parameters));
    ASSERT_TRUE(asked) << asked.error().detail;
    request.parameters = *asked;
    const auto prepared = service.prepare(request, {});
    ASSERT_TRUE(prepared) << prepared.error().detail;
    const ExpectedAnswer expected = expected_answer(*asked, (*prepared)->solid);

    Allowance allowance(0, UINT64_MAX, [](std::uint64_t) { return Allowance::Answer::kGranted; });
    Execution execution;
    execution.allowance = &allowance;
    execution.threads = 2;
    const auto answer = service.fracture(request, execution);
    ASSERT_TRUE(answer) << answer.error().detail;
    const FractureResult& result = *answer->result;
    const nlohmann::json figures = nlohmann::json::parse(result.bytes_of(result.figures));
    const double fragments = figures.at("certificate").at("fragments"),
                 triangles = figures.at("report").at("size").at("triangles"),
                 bytes = static_cast<double>(result.file.size()),
                 working = static_cast<double>(allowance.bytes());
    if (std::getenv("FRACTURE_PRINT_ESTIMATES")) {
      std::printf(
          "%s %s | T %zu parts %zu | sites %.0f/%d | fragments %.0f/%.0f | triangles %.0f/%.0f %.2f | bytes %.0f/%.0f %.2f | "
          "working %.0f/%.0f %.2f |",
          c.mesh, c.parameters, (*prepared)->solid.triangles.size(), (*prepared)->solid.parts.size(),
          expected.sites, figures.at("report").at("sites").at("used").get<int>(), expected.fragments,
          fragments, expected.triangles, triangles, expected.triangles / triangles, expected.file_bytes,
          bytes, expected.file_bytes / bytes, expected.working_bytes, working,
          expected.working_bytes / working);
      for (std::size_t k = 0; k < kProducts; ++k)
        std::printf(" %s %llu", name_of(static_cast<Product>(k)),
                    static_cast<unsigned long long>(allowance.made(static_cast<Product>(k))));
      std::printf("\n");
    }
    EXPECT_TRUE(near(expected.fragments, fragments)) << expected.fragments << " of " << fragments;
    EXPECT_TRUE(near(expected.triangles, triangles)) << expected.triangles << " of " << triangles;
    EXPECT_TRUE(near(expected.file_bytes, bytes)) << expected.file_bytes << " of " << bytes;
    EXPECT_TRUE(near(expected.working_bytes, working)) << expected.working_bytes << " of " << working;
    ++compared;
  }
  if (compared == 0) GTEST_SKIP() << "the meshes are absent";
}

}  // namespace
}  // namespace fracture::test
