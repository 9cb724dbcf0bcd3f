// Choices and warnings about sizes in the reports of the whole service.
#include <gtest/gtest.h>

#include <string>

#include "server/service/mesh_report.hpp"
#include "tests/server/service/hits_fixture.hpp"

namespace fracture::test {
namespace {

/// A cube with this side, as OBJ text.
std::string cube_obj(double side) {
  std::string text;
  for (int k = 0; k < 8; ++k)
    text += "v " + std::to_string(k & 1 ? side : 0) + " " + std::to_string(k & 2 ? side : 0) + " " +
            std::to_string(k & 4 ? side : 0) + "\n";
  return text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

struct Reports {
  json mesh, answer;
};

Reports reports_of(const std::string& mesh, const json& parameters) {
  FractureService service({}, engine_in_process());
  std::vector<RawParameter> given;
  for (const auto& [name, value] : parameters.items()) given.push_back({name, value, false});
  FractureRequest request;
  request.mesh = bytes(mesh);
  request.format = MeshFormat::kObj;
  request.parameters = service.parameters().parse(given).value();
  const json report = mesh_report(*service.prepare(request, {}).value());
  return {report, figures_of(*service.fracture(request, {}).value().result).at("report")};
}

TEST(ReportChoices, AnUnlikelySizeIsInBothReportsUntilTheUnitIsStated) {
  const Reports large = reports_of(cube_obj(500), {{"sites", 3}});
  for (const json& report : {large.mesh, large.answer}) {
    ASSERT_EQ(report.at("choices").size(), 1u) << report;
    EXPECT_EQ(report.at("choices").at(0).at("parameters"), json::parse(R"({"unit": "cm"})")) << "5 m";
    ASSERT_EQ(report.at("warnings").size(), 1u);
    EXPECT_NE(report.at("warnings").at(0).get<std::string>().find("use unit=cm"), std::string::npos);
  }
  for (const char* unit : {"cm", "m"}) {
    const Reports stated = reports_of(cube_obj(500), {{"sites", 3}, {"unit", unit}});
    EXPECT_TRUE(stated.mesh.at("warnings").empty());
    EXPECT_TRUE(stated.mesh.at("choices").empty());
    EXPECT_TRUE(stated.answer.at("warnings").empty());
    EXPECT_FALSE(stated.answer.contains("choices"));
  }
}

// The report on a stored mesh does not depend on the material; that on an answer does.
TEST(ReportChoices, ASizeThatIsTooLargeForItsMaterialIsInTheAnswer) {
  const Reports ceramic =
      reports_of(cube_obj(50), {{"fragments", 3}, {"material", "ceramic"}, {"shell_fraction", 0}});
  EXPECT_TRUE(ceramic.mesh.at("choices").empty());
  EXPECT_EQ(ceramic.answer.at("choices").at(0).at("kind"), "unit");
  const Reports stone = reports_of(cube_obj(50), {{"fragments", 3}, {"material", "stone"}});
  EXPECT_FALSE(stone.answer.contains("choices"));
}

TEST(ReportChoices, TheOfferedWallsAreMade) {
  std::string open = cube_obj(1);
  open.resize(open.rfind("f "));
  const Reports solid = reports_of(open, {{"sites", 3}});
  ASSERT_EQ(solid.answer.at("choices").size(), 1u) << solid.answer;
  const json& lid = solid.answer.at("choices").at(0);
  EXPECT_EQ(lid.at("kind"), "lid");
  json parameters = lid.at("parameters");
  parameters["sites"] = 3;
  const Reports walls = reports_of(open, parameters);
  EXPECT_FALSE(walls.answer.contains("choices"));
  EXPECT_LT(walls.answer.at("solid").at("volume").get<double>(), 0.06) << "five walls of 0.01 m";
}

}  // namespace
}  // namespace fracture::test
