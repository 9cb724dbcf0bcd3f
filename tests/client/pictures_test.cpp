// Pictures in memory and on disk.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "client/render/image.hpp"
#include "client/render/model.hpp"
#include "client/render/text.hpp"
#include "tests/server/support/temporary_folder.hpp"

namespace fracture::test {
namespace {

using render::Color;
using render::Picture;

std::vector<std::uint8_t> bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Png, ComesBackAsItWasWritten) {
  const TemporaryFolder folder;
  std::mt19937 random(3);
  Picture picture(37, 19);
  for (Color& c : picture.pixels)
    c = {static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()),
         static_cast<std::uint8_t>(random()), 255};
  ASSERT_TRUE(write_png(picture, folder / "a.png"));
  const auto back = render::decode_picture(bytes_of(folder / "a.png"));
  ASSERT_TRUE(back) << back.error().detail;
  EXPECT_EQ(back->width, 37);
  EXPECT_EQ(back->height, 19);
  EXPECT_EQ(back->pixels, picture.pixels);
}

TEST(Png, ErrorsAreTyped) {
  const TemporaryFolder folder;
  const auto unwritable = write_png(Picture(4, 4), folder / "no/such/folder.png");
  ASSERT_FALSE(unwritable);
  EXPECT_EQ(unwritable.error().code, ErrorCode::kFileAccess);
  const auto on_a_folder = write_png(Picture(4, 4), folder.path);
  ASSERT_FALSE(on_a_folder);
  EXPECT_EQ(on_a_folder.error().code, ErrorCode::kFileAccess);
  std::ofstream(folder / "mesh.glb") << "glTF";
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  for (const char* name : {"mesh.glb", "pipe"}) {
    const auto refused = write_png(Picture(4, 4), folder / name);
    ASSERT_FALSE(refused) << name << " would be replaced";
    EXPECT_EQ(refused.error().code, ErrorCode::kBadParameter);
  }
  EXPECT_EQ(bytes_of(folder / "mesh.glb").size(), 4u);
  EXPECT_FALSE(std::filesystem::exists(folder / ".mesh.glb.part"));
  std::ofstream(folder / "new") << "";
  for (const char* name : {"new", "new"})  // an empty file, then a picture
    EXPECT_TRUE(write_png(Picture(4, 4), folder / name));
  const auto a_folder = render::load_model(folder.path);
  ASSERT_FALSE(a_folder);
  EXPECT_EQ(a_folder.error().code, ErrorCode::kFileAccess);
  ASSERT_TRUE(write_png(Picture(64, 64), folder / "a.png"));
  std::vector<std::uint8_t> bytes = bytes_of(folder / "a.png");
  bytes.resize(bytes.size() / 2);
  for (const auto& damaged : {bytes, std::vector<std::uint8_t>{}, std::vector<std::uint8_t>{1, 2, 3}}) {
    const auto picture = render::decode_picture(damaged);
    ASSERT_FALSE(picture);
    EXPECT_EQ(picture.error().code, ErrorCode::kBadImage);
  }
}

TEST(Downsample, AveragesLight) {
  Picture board(8, 8);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x)
      board.at(x, y) = (x + y) % 2 == 0 ? Color{255, 255, 255, 255} : Color{0, 0, 0, 255};
  const Picture small = downsample(board, 2);
  ASSERT_EQ(small.width, 4);
  for (const Color& c : small.pixels)
    EXPECT_EQ(c, (Color{188, 188, 188, 255}));  // half the light, IEC 61966-2-1
}

TEST(Paste, CutsOffWhatDoesNotFit) {
  Picture page(4, 4), stamp(3, 3, {9, 9, 9, 255});
  paste(page, stamp, -1, 2);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) EXPECT_EQ(page.at(x, y)[0], x < 2 && y >= 2 ? 9 : 0) << x << ", " << y;
}

TEST(Font, DrawsWithinItsWidthAndReportsAMissingFile) {
  const auto missing = render::Font::open("/nowhere/font.ttf");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kFileAccess);
  const auto font = render::Font::open();
  if (!font) GTEST_SKIP() << font.error().detail;
  Picture page(300, 40, {255, 255, 255, 255});
  const int width = font->width("Glas und Stein ü", 20);
  ASSERT_LT(width, 250);
  font->draw(page, 10, 28, 20, {0, 0, 0, 255}, "Glas und Stein ü");
  int ink = 0;
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 300; ++x)
      if (page.at(x, y)[0] < 128) {
        ++ink;
        EXPECT_TRUE(x >= 9 && x <= 11 + width) << x;
      }
  EXPECT_GT(ink, 200);
  font->draw(page, 290, 5, 40, {0, 0, 0, 255}, "off the page");  // must not write outside the picture
  EXPECT_GT(font->width("WW", 20), font->width("ii", 20));
}

}  // namespace
}  // namespace fracture::test
