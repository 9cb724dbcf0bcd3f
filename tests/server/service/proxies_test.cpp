// Levels of detail and collision geometry in a request: what is broken, and what the answer says.
#include <gtest/gtest.h>

#include <array>
#include <initializer_list>
#include <stdexcept>
#include <string>

#include "tests/server/service/hits_fixture.hpp"

namespace fracture::test {
namespace {

/// A cube of 1 m³ with 12 triangles around (x, 0.5, 0.5), as an object of an OBJ file that already has `objects` of them.
std::string obj_cube(const std::string& name, double x, int objects) {
  std::string text = "o " + name + "\n";
  for (int k = 0; k < 8; ++k)
    text += "v " + std::to_string(x - 0.5 + (k & 1)) + " " + std::to_string(k >> 1 & 1) + " " +
            std::to_string(k >> 2 & 1) + "\n";
  const auto corner = [&](int k) { return " " + std::to_string(8 * objects + 1 + k); };
  for (const auto& [a, b, c, d] : std::initializer_list<std::array<int, 4>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    text += "f" + corner(a) + corner(b) + corner(c) + corner(d) + "\n";
  return text;
}

struct ProxiesTest : testing::Test {
  const std::string mesh = obj_cube("SM_Crate_LOD0", 0, 0) + obj_cube("SM_Crate_LOD1", 0.125, 1) +
                           obj_cube("UCX_SM_Crate_00", 0.25, 2);
  FractureService service{ServiceConfig{}, engine_in_process()};

  json document(json parameters) {
    parameters["sites"] = 5;
    const Expected<FractureAnswer> answer = HitsTest::ask(service, mesh, parameters);
    if (!answer) throw std::runtime_error(answer.error().detail);
    return document_of(*answer->result);
  }
  static const json& figures(const json& document) {
    return document.at("nodes").at(0).at("extras").at("fracture");
  }
};

TEST_F(ProxiesTest, OnlyLevel0IsBrokenAndTheReportNamesTheOthers) {
  const json file = document({});
  EXPECT_NEAR(figures(file).at("certificate").at("volume_out").get<double>(), 1, 1e-9);
  const json& report = figures(file).at("report");
  const std::string warnings = report.at("warnings").dump(), dropped = report.at("dropped").dump();
  for (const char* text : {"UCX_SM_Crate_00", "proxies=geometry"})
    EXPECT_NE(warnings.find(text), std::string::npos) << text;
  for (const char* text : {"SM_Crate_LOD1", "UCX_SM_Crate_00", "proxies=geometry"})
    EXPECT_NE(dropped.find(text), std::string::npos) << text;
  EXPECT_EQ(warnings.find("LOD1"), std::string::npos) << "once is enough";
  for (const json& node : file.at("nodes")) {
    const auto name = node.at("name").get<std::string>();
    EXPECT_EQ(name.find("LOD1"), std::string::npos) << name;
    EXPECT_EQ(name.find("UCX"), std::string::npos) << name;
  }
}

TEST_F(ProxiesTest, AsGeometryAllAreBroken) {
  const json file = document({{"proxies", "geometry"}});
  EXPECT_NEAR(figures(file).at("certificate").at("volume_out").get<double>(), 3, 1e-9);
  EXPECT_EQ(figures(file).at("report").at("warnings").dump().find("proxies"), std::string::npos);
}

TEST_F(ProxiesTest, TheUnbrokenMeshCollidesWithTheGivenHull) {
  const json file = document({{"intact", true}});
  const json& root = file.at("nodes").at(file.at("scenes").at(1).at("nodes").at(0).get<std::size_t>());
  ASSERT_EQ(root.at("children").size(), 1u);
  const json& part = file.at("nodes").at(root.at("children")[0].get<std::size_t>());
  EXPECT_EQ(part.at("name"), "SM_Crate_LOD0_intact");
  const std::size_t hull =
      part.at("extensions").at("KHR_physics_rigid_bodies").at("collider").at("geometry").at("mesh");
  const std::size_t positions =
      file.at("meshes").at(hull).at("primitives").at(0).at("attributes").at("POSITION");
  EXPECT_EQ(file.at("accessors").at(positions).at("min").at(0), -0.25);
  EXPECT_EQ(file.at("accessors").at(positions).at("max").at(0), 0.75);
}

TEST_F(ProxiesTest, AProxyThatIsChosenAloneIsBroken) {
  const json file = document({{"nodes", {"UCX_SM_Crate_00"}}});
  EXPECT_NEAR(figures(file).at("certificate").at("volume_out").get<double>(), 1, 1e-9);
  EXPECT_EQ(file.at("nodes").at(1).at("name").get<std::string>().substr(0, 17), "_UCX_SM_Crate_00_");
}

}  // namespace
}  // namespace fracture::test
