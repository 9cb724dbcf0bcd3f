#include "common/solid/size_check.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

using From = FrameReport::From;

struct Checked {
  Remarks remarks;
  std::vector<Choice> choices;
};

Checked checked(const Mesh& mesh, const FrameReport& frame = {}, bool millimetres_first = false) {
  Checked result;
  check_size(solid_of(mesh), frame, millimetres_first, result.remarks, result.choices);
  return result;
}

Mesh cube_of(double side) { return scaled(cube(), {side, side, side}); }

std::string unit_of(const Checked& result) {
  if (result.choices.size() != 1) return "no choice";
  const Choice& choice = result.choices[0];
  EXPECT_EQ(choice.kind, "unit");
  EXPECT_EQ(choice.parameters.size(), 1u);
  EXPECT_EQ(choice.parameters[0].name, "unit");
  return std::get<std::string>(choice.parameters[0].value);
}

TEST(SizeCheck, TheLikelyUnitGivesAnObjectAUsualSize) {
  using enum LengthUnit;
  EXPECT_EQ(likely_unit(118, 1, true), kMillimetre) << "0.118 m";
  EXPECT_EQ(likely_unit(118, 1, false), kCentimetre) << "1.18 m";
  EXPECT_EQ(likely_unit(5000, 1, false), kMillimetre) << "50 m in centimetres";
  EXPECT_EQ(likely_unit(1e7, 1, false), kMillimetre) << "even 10 km are nearer than 100 km";
  EXPECT_EQ(likely_unit(150, 0.01, false), kMillimetre) << "15 m; centimetres are what was taken";
  EXPECT_EQ(likely_unit(200, 0.001, false), std::nullopt) << "no unit is smaller";
  EXPECT_EQ(likely_unit(5e-4, 0.001, false), kMetre) << "0.5 m";
  EXPECT_EQ(likely_unit(5e-4, 1, false), kKilometre) << "divided by a thousand twice: 0.5 m";
  EXPECT_EQ(likely_unit(5e-4, 1000, false), std::nullopt);
}

TEST(SizeCheck, ACupOfAHundredMetresIsInMillimetres) {
  const Checked cup = checked(cube_of(118), {}, true);
  ASSERT_EQ(cup.remarks.warnings.size(), 1u);
  const std::string& warning = cup.remarks.warnings[0];
  EXPECT_TRUE(warning.starts_with("The mesh is 118 m long")) << warning;
  EXPECT_NE(warning.find("(assumed)"), std::string::npos) << warning;
  EXPECT_NE(warning.find("use unit=mm: it is then 0.118 m long"), std::string::npos) << warning;
  EXPECT_NE(warning.find("If the size is right, use unit=m"), std::string::npos) << warning;
  EXPECT_EQ(unit_of(cup), "mm");
  EXPECT_NE(cup.choices[0].text.find("0.118 m"), std::string::npos);
}

TEST(SizeCheck, ASpeckIsSaidToBeTooSmall) {
  const Checked speck = checked(cube_of(0.0005), {.metres_per_unit = 0.001, .unit_from = From::kFile});
  ASSERT_EQ(speck.remarks.warnings.size(), 1u);
  EXPECT_NE(speck.remarks.warnings[0].find("as the file says"), std::string::npos)
      << speck.remarks.warnings[0];
  EXPECT_EQ(unit_of(speck), "m");
}

TEST(SizeCheck, UsualSizesAndStatedUnitsPass) {
  for (const double side : {0.001, 0.3, 99.9}) EXPECT_TRUE(checked(cube_of(side)).remarks.empty()) << side;
  const FrameReport stated{.metres_per_unit = 1, .unit_from = From::kRequest};
  for (const double side : {1e-5, 1e5}) EXPECT_TRUE(checked(cube_of(side), stated).remarks.empty()) << side;
  std::vector<Mesh> town;
  for (int k = 0; k < 20; ++k) town.push_back(translated(cube_of(30), {60.0 * k, 0, 0}));
  EXPECT_TRUE(checked(joined(town)).remarks.empty()) << "1,170 m of houses";
}

TEST(SizeCheck, AnObjectOfAThousandPiecesInARowIsToldByItsMaterial) {
  const Solid solid = solid_of(cube_of(50));
  const auto with = [&](const Solid& of, double piece) {
    Checked result;
    check_size(of, {}, false, {"ceramic", piece}, result.remarks, result.choices);
    return result;
  };
  EXPECT_EQ(unit_of(with(solid, 0.03)), "cm") << "0.5 m";
  EXPECT_NE(with(solid, 0.03).remarks.warnings.at(0).find("pieces of ceramic, 0.03 m"), std::string::npos);
  EXPECT_TRUE(with(solid, 0.05).remarks.empty());
  EXPECT_TRUE(with(solid, 0).remarks.empty()) << "no material";
  EXPECT_TRUE(with(solid_of(cube_of(200)), 0.03).remarks.empty()) << "the size alone was enough";
}

}  // namespace
}  // namespace fracture::test
