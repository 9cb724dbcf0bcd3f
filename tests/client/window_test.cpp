// The program with a window, on a display server without a screen.
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <set>
#include <sstream>
#include <thread>

#include "client/render/image.hpp"
#include "tests/server/support/child_process.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::app {
namespace {

using test::ChildProcess;

class OnADisplay : public testing::Test {
 protected:
  void SetUp() override {
    const auto program = test::find_program("Xvfb");
    if (!program) GTEST_SKIP() << "Xvfb is not installed";
    display_.emplace(std::vector<std::string>{*program, "-displayfd", "1", "-screen", "0", "800x600x24"},
                     folder_ / "display");
    std::string number;
    ASSERT_TRUE(test::eventually(test::kPatience, "the display's number", [&] {
      number = display_number(test::read_file(folder_ / "display"));
      return !number.empty() || !display_->alive();
    }));
    ASSERT_FALSE(number.empty()) << test::read_file(folder_ / "display");
    const std::string display = ":" + number;
    ::setenv("DISPLAY", display.c_str(), 1);
  }

  /// The line that consists only of digits; the X server may print other lines before and after it.
  static std::string display_number(const std::string& said) {
    std::istringstream lines(said.substr(0, said.rfind('\n') + 1));
    for (std::string line; std::getline(lines, line);)
      if (!line.empty() && line.find_first_not_of("0123456789") == std::string::npos) return line;
    return {};
  }

  int play(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), FRACTURE_CLIENT_PROGRAM);
    ChildProcess client(arguments, folder_ / "output");
    return client.wait();
  }

  test::TemporaryFolder folder_;
  std::optional<ChildProcess> display_;
};

TEST_F(OnADisplay, TheGameOpensPlaysAndCloses) {
  test::ServeProcess server;
  ASSERT_EQ(play({"--scene", "monkey", "--gravity", "--port", std::to_string(server.port), "--width", "480",
                  "--height", "320", "--close-after", "2", "--out", folder_.path}),
            0)
      << test::read_file(folder_ / "output");
  const std::string bytes = test::read_file(folder_ / "window.png");
  const auto picture =
      render::decode_picture(std::span(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()));
  ASSERT_TRUE(picture) << picture.error().detail;
  EXPECT_EQ(picture->width, 480);
  EXPECT_EQ(picture->height, 320);
  std::set<render::Color> colors(picture->pixels.begin(), picture->pixels.end());
  EXPECT_GT(colors.size(), 100u);  // the picture is not empty
}

TEST_F(OnADisplay, WithoutAServerTheWindowOpensAllTheSame) {
  EXPECT_EQ(play({"--scene", "crates", "--gravity", "--port", std::to_string(test::free_port()), "--width",
                  "320", "--height", "240", "--close-after", "1", "--out", folder_.path}),
            0)
      << test::read_file(folder_ / "output");
}

TEST_F(OnADisplay, AGameIsGoneOnWith) {
  test::ServeProcess server;
  const std::string port = std::to_string(server.port), first = folder_ / "first.jsonl",
                    second = folder_ / "second.jsonl";
  ASSERT_EQ(play({"--headless", "--fixed-step", "--scene", "panes", "--seconds", "1.5", "--port", port,
                  "--log", first}),
            0)
      << test::read_file(folder_ / "output");
  const std::string recorded = test::read_file(first);
  ASSERT_NE(recorded.find("adopt"), std::string::npos);
  ChildProcess client({FRACTURE_CLIENT_PROGRAM, "--continue", first, "--log", second, "--gravity", "--port",
                       port, "--width", "320", "--height", "240", "--out", folder_.path},
                      folder_ / "output");
  ASSERT_TRUE(test::eventually(test::kPatience, "steps after the recorded ones", [&] {
    return test::read_file(second).size() > recorded.size() || !client.alive();
  }));
  EXPECT_TRUE(client.alive()) << test::read_file(folder_ / "output");
  EXPECT_EQ(test::read_file(second).substr(0, recorded.size()), recorded);
}

TEST(Window, WithoutADisplayTheProgramSaysSo) {
  test::TemporaryFolder folder;
  ::unsetenv("DISPLAY");
  ::unsetenv("WAYLAND_DISPLAY");
  ChildProcess client({FRACTURE_CLIENT_PROGRAM}, folder / "output");
  EXPECT_EQ(client.wait(), 1);
  EXPECT_NE(test::read_file(folder / "output").find("--headless"), std::string::npos);
}

TEST(CommandLine, MistakesAreNamed) {
  test::TemporaryFolder folder;
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"--scene", "castle"},
                                                    {"--fixed-step"},
                                                    {"--headless", "--seconds", "-1"},
                                                    {"--picture", "best"},
                                                    {"--continue", "game.jsonl", "--scene", "wall"},
                                                    {"--headless", "--explode", "1,2,3"},
                                                    {"--headless", "--invite", "0"},
                                                    {"--headless", "--join", "7000", "--seed", "1"},
                                                    {"--headless", "--join", "7000", "--seconds", "1"},
                                                    {"--headless", "--explode", "-1,0,0,0"},
                                                    {"--headless", "--explode", "1,0,0,0,-5"},
                                                    {"--headless", "--seconds", "nan"},
                                                    {"--headless", "--screenshot-at", "nan"},
                                                    {"--seed", "-1"},
                                                    {"--seed", "18446744073709551616"},
                                                    {"--port", "x"}}) {
    std::vector<std::string> all = {FRACTURE_CLIENT_PROGRAM};
    all.insert(all.end(), arguments.begin(), arguments.end());
    ChildProcess client(all, folder / "output");
    EXPECT_EQ(client.wait(), 2) << arguments[0];
    EXPECT_NE(test::read_file(folder / "output")
                  .find(arguments.size() > 1 ? arguments[arguments.size() - 2] : arguments[0]),
              std::string::npos)
        << test::read_file(folder / "output");
  }
}

}  // namespace
}  // namespace fracture::app
