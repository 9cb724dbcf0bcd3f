// Options of pictures and contact sheets, without a display.
#include "client/cli/sheet.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/render/text.hpp"
#include "tests/server/support/temporary_folder.hpp"

namespace fracture::test {
namespace {

using cli::PictureOptions;
using nlohmann::json;

TEST(PictureOptions, EveryOptionRefusesNonsenseByNameAndRange) {
  for (const cli::OptionSpec& spec : cli::option_specs()) {
    if (std::string(spec.name) == "file") continue;
    for (const json& bad : {json("nonsense"), json(json::array({1})), json(nullptr), json(1e99)}) {
      PictureOptions options;
      const auto set = set_options(options, {{spec.name, bad}}, "here");
      ASSERT_FALSE(set) << spec.name << " took " << bad;
      EXPECT_EQ(set.error().code, ErrorCode::kBadParameter);
      EXPECT_THAT(set.error().detail,
                  testing::AllOf(testing::HasSubstr(spec.name), testing::HasSubstr("must be")));
    }
  }
  PictureOptions options;
  const auto unknown = set_options(options, {{"colour", "red"}}, "here");
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().detail, testing::HasSubstr("no option 'colour'"));
}

TEST(PictureOptions, TextAndNumbersMeanTheSame) {
  PictureOptions a, b;
  ASSERT_TRUE(set_options(
      a, {{"yaw", "-12.5"}, {"impact", "1,2,-3"}, {"size", "320x200"}, {"orthographic", "true"}}, ""));
  ASSERT_TRUE(set_options(
      b, {{"yaw", -12.5}, {"impact", {1, 2, -3}}, {"size", "320x200"}, {"orthographic", true}}, ""));
  EXPECT_EQ(a.camera.yaw, -12.5f);
  EXPECT_EQ(a.camera.yaw, b.camera.yaw);
  EXPECT_EQ(*a.view.impact_point, glm::vec3(1, 2, -3));
  EXPECT_EQ(a.view.impact_point, b.view.impact_point);
  EXPECT_EQ(a.width, 320);
  EXPECT_EQ(a.height, 200);
  EXPECT_TRUE(a.camera.orthographic && b.camera.orthographic);
}

TEST(Sheet, OptionsOfRowColumnAndCellAddUpInThisOrder) {
  const TemporaryFolder folder;
  const json sheet = {
      {"options", {{"size", "64x48"}, {"yaw", 1}, {"pitch", 1}, {"explode", 1}, {"file", "x.glb"}}},
      {"rows",
       {{{"label", "r0"}}, {{"label", "r1"}, {"options", {{"yaw", 2}, {"pitch", 2}, {"explode", 2}}}}}},
      {"columns", {{{"label", "c0"}}, {{"label", "c1"}, {"options", {{"pitch", 3}, {"explode", 3}}}}}},
      {"cells", {json::array(), {json::object(), {{"explode", 4}, {"file", "y.glb"}}}}}};
  const auto read = cli::read_sheet(folder.write("sheet.json", sheet.dump()));
  ASSERT_TRUE(read) << read.error().detail;
  ASSERT_EQ(read->cells.size(), 4u);
  const auto values = [&](std::size_t k) {
    const PictureOptions& o = read->cells[k];
    return std::array{o.camera.yaw, o.camera.pitch, o.view.explode};
  };
  EXPECT_EQ(values(0), (std::array{1.f, 1.f, 1.f}));
  EXPECT_EQ(values(1), (std::array{1.f, 3.f, 3.f}));
  EXPECT_EQ(values(2), (std::array{2.f, 2.f, 2.f}));
  EXPECT_EQ(values(3), (std::array{2.f, 3.f, 4.f}));
  EXPECT_EQ(read->cells[0].file, folder / "x.glb");
  EXPECT_EQ(read->cells[3].file, folder / "y.glb");
}

TEST(Sheet, ErrorsNameThePlace) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& text) {
    const auto read = cli::read_sheet(folder.write("sheet.json", text));
    return read ? std::string("read") : read.error().detail;
  };
  EXPECT_THAT(error("{"), testing::HasSubstr("not valid JSON"));
  EXPECT_THAT(error("[]"), testing::HasSubstr("must contain a JSON object"));
  EXPECT_THAT(error("{}"), testing::HasSubstr("the cell 0/0 (row/column) has no file"));
  EXPECT_THAT(error(R"({"row": []})"), testing::HasSubstr("no member 'row'"));
  EXPECT_THAT(error(R"({"rows": 3})"), testing::HasSubstr("/rows must be an array"));
  EXPECT_THAT(error(R"({"rows": [{"label": 3}]})"), testing::HasSubstr("/rows/0"));
  EXPECT_THAT(error(R"({"options": {"file": "a"}, "columns": [{"options": {"yaw": 1000}}]})"),
              testing::AllOf(testing::HasSubstr("/columns/0"),
                             testing::HasSubstr("'yaw' must be a number from -360 to 360")));
  EXPECT_THAT(error(R"({"options": {"file": "a"}, "cells": [[{"yaw": "east"}]]})"),
              testing::HasSubstr("/cells/0/0"));
  EXPECT_EQ(cli::read_sheet(folder / "none.json").error().code, ErrorCode::kFileAccess);
}

TEST(Sheet, PutsEveryPictureInItsPlaceAndLabelsBeside) {
  if (const auto font = render::Font::open(); !font) GTEST_SKIP() << font.error().detail;
  const TemporaryFolder folder;
  const json sheet = {{"title", "Title"},
                      {"options", {{"size", "40x30"}, {"file", "x.glb"}}},
                      {"rows", {{{"label", "one"}}, {{"label", "two"}}, {{"label", "three"}}}},
                      {"columns", {{{"label", "a"}}, {{"label", "b"}}}}};
  const auto read = cli::read_sheet(folder.write("sheet.json", sheet.dump()));
  ASSERT_TRUE(read) << read.error().detail;
  std::uint8_t next = 0;
  const auto page = compose_sheet(*read, [&](const PictureOptions& o) -> Expected<render::Picture> {
    return render::Picture(o.width, o.height, {255, static_cast<std::uint8_t>(10 * next++), 0, 255});
  });
  ASSERT_TRUE(page) << page.error().detail;
  EXPECT_EQ(next, 6);
  std::array<int, 6> pixels{};
  int ink = 0;
  std::array<int, 6> left{}, top{};
  for (int y = 0; y < page->height; ++y)
    for (int x = 0; x < page->width; ++x) {
      const render::Color& c = page->at(x, y);
      if (c[0] == 255 && c[2] == 0) {
        const auto k = static_cast<std::size_t>(c[1] / 10);
        if (pixels[k]++ == 0) left[k] = x, top[k] = y;
      } else if (c[0] < 128) {
        ++ink;
      }
    }
  for (const int count : pixels) EXPECT_EQ(count, 40 * 30);  // none covered by another or by a label
  EXPECT_LT(left[0], left[1]);
  EXPECT_EQ(top[0], top[1]);
  EXPECT_LT(top[1], top[2]);
  EXPECT_EQ(left[0], left[2]);
  EXPECT_GT(ink, 60);

  const auto failing = compose_sheet(*read, [](const PictureOptions&) -> Expected<render::Picture> {
    return fail(ErrorCode::kMalformedMesh, "no such mesh");
  });
  ASSERT_FALSE(failing);
  EXPECT_EQ(failing.error().detail, "no such mesh");
}

}  // namespace
}  // namespace fracture::test
