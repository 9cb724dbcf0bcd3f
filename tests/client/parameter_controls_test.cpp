#include "client/app/parameter_controls.hpp"

#include <gtest/gtest.h>

namespace fracture::app {
namespace {

using nlohmann::json;

const char* const kTable = R"({
  "patterns": [{"name": "uniform", "description": "", "parameters": []},
               {"name": "grid", "description": "", "parameters": [
                 {"name": "jitter", "type": "number", "minimum": 0, "maximum": 1, "description": "d"},
                 {"name": "cell", "type": "array", "text": "x,y,z", "unit": "m", "description": "d"}]}],
  "parameters": [{"name": "pattern", "type": "string", "enum": ["uniform", "grid"], "default": "uniform", "description": "d"},
                 {"name": "sites", "type": "integer", "minimum": 1, "maximum": 100000, "default": 50, "description": "d"},
                 {"name": "fragment", "type": "integer", "minimum": 0, "maximum": 9, "description": "ours"}],
  "materials": []})";

TEST(ParameterControls, AreBuiltFromTheServersTable) {
  ParameterControls controls;
  ASSERT_TRUE(controls.read(kTable));
  ASSERT_EQ(controls.shown().size(), 2u);  // the game itself uses `fragment`
  const ParameterControl& sites = *controls.find("sites");
  EXPECT_EQ(sites.type, ParameterControl::Type::kInteger);
  EXPECT_EQ(sites.low, 1);
  EXPECT_EQ(sites.high, 100000);
  EXPECT_EQ(sites.number, 50);
  EXPECT_EQ(controls.find("pattern")->choices, (std::vector<std::string>{"uniform", "grid"}));
  EXPECT_EQ(controls.values(), json::object());
}

TEST(ParameterControls, ThoseOfThePatternComeWithIt) {
  ParameterControls controls;
  ASSERT_TRUE(controls.read(kTable));
  EXPECT_EQ(controls.find("cell"), nullptr);
  controls.find("pattern")->set = true;
  controls.find("pattern")->choice = 1;
  ASSERT_NE(controls.find("cell"), nullptr);
  EXPECT_EQ(controls.find("cell")->unit, "m");
  controls.find("cell")->set = true;
  controls.find("cell")->text = "0.1,0.2,0.3";
  controls.find("jitter")->set = true;
  controls.find("jitter")->number = 7;  // above its limit
  EXPECT_EQ(controls.values(), (json{{"pattern", "grid"}, {"cell", "0.1,0.2,0.3"}, {"jitter", 1.0}}));
}

TEST(ParameterControls, NonsenseIsNoTable) {
  ParameterControls controls;
  for (const char* text : {"", "{", "[]", "{}", R"({"patterns": 3, "parameters": []})"})
    EXPECT_FALSE(controls.read(text)) << text;
  EXPECT_TRUE(controls.empty());
}

}  // namespace
}  // namespace fracture::app
