// Many pictures by a single process, without a display.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <vector>

#include "client/cli/draw_list.hpp"

namespace fracture::test {
namespace {

using cli::PictureOptions;
using nlohmann::json;
using testing::HasSubstr;

TEST(PictureList, EveryLineIsDrawnOrSaysWhyNotAndTheNextOneGoesOn) {
  std::istringstream in(
      "{\"file\": \"a.glb\", \"output\": \"a.png\", \"size\": \"64x48\", \"view\": \"exploded\"}\n"
      "no JSON\n"
      "[]\n"
      "{\"file\": \"b.glb\"}\n"
      "{\"output\": \"b.png\"}\n"
      "{\"file\": \"b.glb\", \"output\": \"b.png\", \"size\": \"1x1\"}\n"
      "{\"file\": \"b.glb\", \"output\": \"b.png\", \"colour\": \"red\"}\n"
      "{\"file\": \"absent.glb\", \"output\": \"absent\\u00e9.png\"}\n"
      "{\"file\": \"c.glb\", \"output\": \"c.png\"}");
  std::ostringstream out;
  std::vector<std::string> asked;
  cli::draw_list(in, out, [&](const PictureOptions& options, const std::string& output) -> Expected<void> {
    asked.push_back(options.file + " " + output + " " + std::to_string(options.width));
    if (options.file == "absent.glb") return fail(ErrorCode::kFileAccess, "Cannot read it: \xff.");
    return {};
  });
  EXPECT_EQ(asked, (std::vector<std::string>{"a.glb a.png 64", "absent.glb absent\u00e9.png 800",
                                             "c.glb c.png 800"}));

  std::vector<json> answers;
  std::istringstream lines(out.str());
  for (std::string line; std::getline(lines, line);) answers.push_back(json::parse(line));
  ASSERT_EQ(answers.size(), 9u);
  EXPECT_EQ(answers[0], (json{{"output", "a.png"}}));
  EXPECT_EQ(answers[8], (json{{"output", "c.png"}}));
  const std::vector<std::pair<const char*, const char*>> problems{{"bad-json", "JSON object"},
                                                                  {"bad-json", "JSON object"},
                                                                  {"bad-parameter", "'output'"},
                                                                  {"bad-parameter", "'file'"},
                                                                  {"bad-parameter", "'size'"},
                                                                  {"bad-parameter", "'colour'"},
                                                                  {"file-access", "Cannot read it: \uFFFD"}};
  for (std::size_t k = 0; k < problems.size(); ++k) {
    const json& answer = answers[k + 1];
    ASSERT_TRUE(answer.contains("problem")) << answer;
    EXPECT_EQ(answer["problem"]["type"], std::string("/problems/") + problems[k].first);
    EXPECT_THAT(answer["problem"]["detail"].get<std::string>(), HasSubstr(problems[k].second));
  }
  EXPECT_EQ(answers[7]["output"], "absent\u00e9.png");
}

}  // namespace
}  // namespace fracture::test
