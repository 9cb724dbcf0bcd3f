// Textures in WebP and KTX2. WebP files come from libwebp's lossless encoder, and KTX2 files are built here from the
// specification.
#include <gtest/gtest.h>
#include <webp/encode.h>
#include <zstd.h>

#include <string>
#include <utility>

#include "common/mesh/material_library.hpp"
#include "common/surface_color/mean_pyramid.hpp"
#include "common/surface_color/surface_colors.hpp"

namespace fracture {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Pixel = std::array<std::uint8_t, 4>;

Bytes webp(int width, int height, const Bytes& rgba) {
  std::uint8_t* out = nullptr;
  const std::size_t size = WebPEncodeLosslessRGBA(rgba.data(), width, height, 4 * width, &out);
  Bytes file(out, out + size);
  WebPFree(out);
  return file;
}

void put(Bytes& file, std::uint64_t value, std::size_t size) {
  for (std::size_t k = 0; k < size; ++k) file.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
}

struct Ktx2 {
  std::uint32_t format = 0, width = 1, height = 1, supercompression = 0;
  std::uint8_t model = 1;     ///< 1: RGB; 163: ETC1S; 166: UASTC
  std::vector<Bytes> levels;  ///< largest first
};

/// Header, level index, a data format descriptor with only its head and its colour model, and the levels.
Bytes file_of(const Ktx2& texture) {
  const std::string magic("\xabKTX 20\xbb\r\n\x1a\n", 12);
  Bytes file(magic.begin(), magic.end());
  const std::size_t descriptor = 80 + 24 * texture.levels.size(), length = 28;
  for (const std::size_t word :
       {std::size_t{texture.format}, std::size_t{1}, std::size_t{texture.width}, std::size_t{texture.height},
        std::size_t{0}, std::size_t{0}, std::size_t{1}, texture.levels.size(),
        std::size_t{texture.supercompression}, descriptor, length, std::size_t{0}, std::size_t{0}})
    put(file, word, 4);
  put(file, 0, 8);
  put(file, 0, 8);
  std::size_t at = descriptor + length;
  for (const Bytes& level : texture.levels) {
    put(file, at, 8);
    put(file, level.size(), 8);
    put(file, level.size(), 8);
    at += level.size();
  }
  put(file, length, 4);
  put(file, 0, 4);
  put(file, 2 | (length - 4) << 16, 4);
  file.push_back(texture.model);
  file.resize(descriptor + length, 0);
  for (const Bytes& level : texture.levels) file.insert(file.end(), level.begin(), level.end());
  return file;
}

/// A UASTC block of one colour: mode 8 is 0b10111 in five bits, then red, green, blue and opacity follow with eight bits each.
Bytes block_of(const Pixel& color) {
  std::uint64_t bits = 0x17;
  for (std::size_t k = 0; k < 4; ++k) bits |= std::uint64_t{color[k]} << (5 + 8 * k);
  Bytes block;
  put(block, bits, 8);
  block.resize(16, 0);
  return block;
}

Pixel first_of(const Bytes& file) {
  const std::optional<Pixels> pixels = decode_image(file);
  EXPECT_TRUE(pixels);
  return pixels ? pixels->at(0, 0) : Pixel{};
}

TEST(Textures, WebPHasThePixelsThatWereEncoded) {
  const Bytes file = webp(2, 1, {10, 20, 30, 255, 200, 100, 50, 128});
  EXPECT_EQ(pixel_count(file), 2u);
  const std::optional<Pixels> pixels = decode_image(file);
  ASSERT_TRUE(pixels);
  EXPECT_EQ(pixels->at(0, 0), (Pixel{10, 20, 30, 255}));
  EXPECT_EQ(pixels->at(1, 0), (Pixel{200, 100, 50, 128}));
  EXPECT_FALSE(decode_image(std::span(file).first(file.size() - 8)));
}

TEST(Textures, Ktx2IsReadInEachOrderOfChannels) {
  EXPECT_EQ(first_of(file_of({.format = 43, .levels = {{1, 2, 3, 4}}})), (Pixel{1, 2, 3, 4}));
  EXPECT_EQ(first_of(file_of({.format = 50, .levels = {{1, 2, 3, 4}}})), (Pixel{3, 2, 1, 4}));
  EXPECT_EQ(first_of(file_of({.format = 29, .levels = {{1, 2, 3}}})), (Pixel{1, 2, 3, 255}));
  EXPECT_EQ(first_of(file_of({.format = 36, .levels = {{1, 2, 3}}})), (Pixel{3, 2, 1, 255}));
  const Bytes two = file_of({.format = 29, .width = 2, .levels = {{9, 9, 9, 1, 2, 3}, {5, 5, 5}}});
  EXPECT_EQ(pixel_count(two), 2u);
  EXPECT_EQ(decode_image(two).value().at(1, 0), (Pixel{1, 2, 3, 255}));
  EXPECT_FALSE(decode_image(std::span(two).first(two.size() - 4)))
      << "cut off within the first level's bytes";
}

TEST(Textures, Ktx2InZstandardIsRead) {
  Bytes level(ZSTD_compressBound(4));
  const Bytes pixel{7, 8, 9, 10};
  level.resize(ZSTD_compress(level.data(), level.size(), pixel.data(), pixel.size(), 3));
  EXPECT_EQ(first_of(file_of({.format = 37, .supercompression = 2, .levels = {level}})),
            (Pixel{7, 8, 9, 10}));
}

TEST(Textures, UastcGivesTheColourOfItsSmallestLevel) {
  const Ktx2 texture{.format = 0,
                     .width = 4,
                     .height = 2,
                     .model = 166,
                     .levels = {Bytes(16, 0), Bytes(16, 0), block_of({200, 100, 50, 255})}};
  const Bytes file = file_of(texture);
  EXPECT_EQ(pixel_count(file), 1u);
  EXPECT_EQ(first_of(file), (Pixel{200, 100, 50, 255}));
}

TEST(Textures, EncodingsThatAreNotReadSayWhy) {
  const auto reason = [](const Bytes& file) {
    EXPECT_FALSE(pixel_count(file));
    EXPECT_FALSE(decode_image(file));
    return std::string(why_unread(file));
  };
  const auto contains = [](const std::string& text, const char* part) {
    return text.find(part) != text.npos;
  };
  EXPECT_TRUE(
      contains(reason(file_of({.supercompression = 1, .model = 163, .levels = {Bytes(4)}})), "BasisLZ"));
  EXPECT_TRUE(contains(reason(file_of({.width = 8, .model = 166, .levels = {Bytes(32)}})), "1 x 1"));
  EXPECT_TRUE(contains(reason(file_of({.model = 166, .levels = {Bytes(16)}})), "single colour"));
  EXPECT_TRUE(contains(reason(file_of({.format = 146, .levels = {Bytes(16)}})), "format"));  // BC7
  EXPECT_TRUE(contains(reason({'R', 'I', 'F', 'F'}), "neither"));
}

TEST(Textures, EveryTruncationIsSafe) {
  const Bytes file =
      file_of({.width = 2, .height = 2, .model = 166, .levels = {Bytes(16), block_of({1, 2, 3, 4})}});
  for (std::size_t size = 0; size < file.size(); ++size) {
    (void)pixel_count(std::span(file).first(size));
    (void)decode_image(std::span(file).first(size));
  }
}

TEST(Textures, ARemarkNamesTheMaterial) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.material = {0};
  mesh.node = {0};
  mesh.node_names = {"n"};
  mesh.attributes.uvs = {{{0, 0}, {1, 0}, {0, 1}}};
  auto library = std::make_shared<MaterialLibrary>();
  library->materials = {{{"name", "Oak"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
  library->textures = {{{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}}};
  library->images.push_back(
      {"", "image/ktx2", file_of({.supercompression = 1, .model = 163, .levels = {Bytes(4)}})});
  mesh.library = library;
  Remarks remarks;
  EXPECT_TRUE(surface_colors(mesh, remarks).empty());
  ASSERT_EQ(remarks.notes.size(), 1u);
  EXPECT_NE(remarks.notes[0].find("the material \"Oak\""), std::string::npos) << remarks.notes[0];
  EXPECT_EQ(remarks.notes[0].find("\"\""), std::string::npos) << remarks.notes[0];

  library->images[0].bytes = file_of({.format = 43, .levels = {{255, 0, 255, 255}}});
  const std::vector<SurfaceColor> colors = surface_colors(mesh, remarks);
  ASSERT_EQ(colors.size(), 1u);
  EXPECT_EQ(colors[0], (SurfaceColor{{65535, 0, 65535}, 1}));
}

}  // namespace
}  // namespace fracture
