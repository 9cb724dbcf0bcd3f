#include "common/surface_color/surface_colors.hpp"

#include <gtest/gtest.h>

#include <string>

#include "common/mesh/material_library.hpp"
#include "common/surface_color/mean_pyramid.hpp"
#include "tests/surface_color/pictures.hpp"

namespace fracture {
namespace {

using nlohmann::json;
using test::png;

SurfaceColor of(std::uint16_t red, std::uint16_t green, std::uint16_t blue) {
  return {{red, green, blue}, 1};
}
const SurfaceColor kUnknown{};

std::vector<SurfaceColor> colors_of(const Mesh& mesh, const PixelLimits& limits = {}) {
  Remarks remarks;
  return surface_colors(mesh, remarks, limits);
}

/// Squares of two triangles each. Their UVs are the given rectangles (u, v, width, height).
Mesh squares(const std::vector<std::array<float, 4>>& rectangles) {
  Mesh mesh;
  auto& uvs = mesh.attributes.uvs.emplace_back();
  for (const auto& [u, v, w, h] : rectangles) {
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    for (const auto& [x, y] : {std::pair{0.f, 0.f}, {1.f, 0.f}, {1.f, 1.f}, {0.f, 1.f}}) {
      mesh.positions.push_back({x, y, static_cast<float>(base)});
      uvs.push_back({u + x * w, v + y * h});
    }
    mesh.triangles.push_back({base, base + 1, base + 2});
    mesh.triangles.push_back({base, base + 2, base + 3});
  }
  mesh.material.assign(mesh.triangles.size(), 0);
  mesh.node.assign(mesh.triangles.size(), 0);
  mesh.node_names = {"squares"};
  return mesh;
}

/// Gives the mesh one material with that image as its base colour.
void paint(Mesh& mesh, std::vector<std::uint8_t> image, json factor = {1, 1, 1, 1}) {
  auto library = std::make_shared<MaterialLibrary>();
  library->materials = {
      {{"pbrMetallicRoughness", {{"baseColorFactor", factor}, {"baseColorTexture", {{"index", 0}}}}}}};
  library->textures = {{{"source", 0}}};
  library->images.push_back({"image", "image/png", std::move(image)});
  mesh.library = std::move(library);
}

/// Four squares of 16 pixels: red, green, blue, white.
std::array<int, 4> palette(int x, int y) {
  const int k = x / 16 + 2 * (y / 16);
  return {k == 0 || k == 3 ? 255 : 0, k == 1 || k == 3 ? 255 : 0, k >= 2 ? 255 : 0, 255};
}

TEST(SurfaceColors, APaletteGivesEachTriangleItsOwn) {
  Mesh mesh = squares({{0.25, 0.25, 0, 0}, {0.75, 0.25, 0, 0}, {0.1, 0.6, 0.3, 0.3}, {1.6, -0.4, 0.3, 0.3}});
  paint(mesh, png(32, 32, palette), {0.5, 1, 1, 1});
  const std::vector<SurfaceColor> colors = colors_of(mesh);
  ASSERT_EQ(colors.size(), 8u);
  for (const std::size_t half : {0, 1}) {
    EXPECT_EQ(colors[half], of(32768, 0, 0));
    EXPECT_EQ(colors[2 + half], of(0, 65535, 0));
    EXPECT_EQ(colors[4 + half], of(0, 0, 65535));
    EXPECT_EQ(colors[6 + half], of(32768, 65535, 65535)) << "repeated";
  }
}

TEST(SurfaceColors, ATriangleOverManyPixelsHasTheirMean) {
  Mesh mesh = squares({{0, 0, 1, 1}, {0, 0, 8, 8}});
  // Fine stripes: a few samples alone would depend on chance.
  paint(mesh, png(256, 256, [](int x, int) {
          const int v = x % 4 == 0 ? 255 : 0;
          return std::array{v, v, v, 255};
        }));
  for (const SurfaceColor& color : colors_of(mesh)) EXPECT_NEAR(color.light[0], 65535 / 4, 700);
}

TEST(SurfaceColors, VertexColorsMultiply) {
  Mesh mesh = squares({{0, 0, 1, 1}});
  mesh.attributes.colors.push_back({{1, 0.5, 0, 1}, {1, 0.5, 0, 1}, {1, 0.5, 0, 1}, {1, 0.5, 0.6f, 1}});
  paint(mesh, png(1, 1, [](int, int) { return std::array{255, 255, 255, 255}; }), {0.5, 1, 1, 1});
  EXPECT_EQ(colors_of(mesh)[0], of(32768, 32768, 0));
  EXPECT_EQ(colors_of(mesh)[1], of(32768, 32768, 13107));
}

TEST(SurfaceColors, WhereNothingHasAColorThereAreNone) {
  Mesh mesh = squares({{0, 0, 1, 1}});
  mesh.material.assign(2, kNoIndex);
  EXPECT_TRUE(colors_of(mesh).empty());
  mesh.attributes.colors.push_back({4, {0, 1, 0, 1}});
  EXPECT_EQ(colors_of(mesh).size(), 2u);
}

TEST(SurfaceColors, OfAnImageThatCannotBeReadNothingIsKnown) {
  Mesh mesh = squares({{0, 0, 1, 1}, {0, 0, 1, 1}});
  paint(mesh, {'R', 'I', 'F', 'F'}, {0.5, 0.5, 0.5, 1});
  Remarks remarks;
  EXPECT_TRUE(surface_colors(mesh, remarks).empty());
  EXPECT_TRUE(remarks.warnings.empty());
  ASSERT_EQ(remarks.notes.size(), 1u) << "once for each image";
  EXPECT_NE(remarks.notes[0].find("neither PNG, JPEG, WebP nor KTX2"), std::string::npos);
  EXPECT_NE(remarks.notes[0].find("of material 0"), std::string::npos);
  // A triangle without a material next to one with a known colour.
  paint(mesh, png(1, 1, [](int, int) { return std::array{255, 0, 0, 255}; }));
  mesh.material[3] = kNoIndex;
  EXPECT_EQ(colors_of(mesh)[0], of(65535, 0, 0));
  EXPECT_EQ(colors_of(mesh)[3], kUnknown);
}

TEST(SurfaceColors, ASwatchIsNotMixedWithWhatIsBesideIt) {
  // A swatch on black that begins at odd pixels, and squares that cover it to its edge.
  for (const int side : {6, 12, 50}) {
    Mesh mesh = squares({{3 / 64.f, 3 / 64.f, side / 64.f, side / 64.f}});
    paint(mesh, png(64, 64, [&](int x, int y) {
            const int v = x >= 3 && x < 3 + side && y >= 3 && y < 3 + side ? 255 : 0;
            return std::array{v, v, v, 255};
          }));
    for (const SurfaceColor& color : colors_of(mesh)) EXPECT_GT(color.light[0], 0.96 * 65535) << side;
  }
}

TEST(SurfaceColors, MorePixelsThanMayBeAreNotLookedAt) {
  Mesh mesh = squares({{0, 0, 1, 1}});
  mesh.triangles.push_back(mesh.triangles[0]);  // a triangle with a known colour
  mesh.material.push_back(kNoIndex);
  mesh.attributes.colors.push_back({4, {1, 1, 1, 1}});
  paint(mesh, png(16, 16, [](int, int) { return std::array{0, 0, 0, 255}; }));
  const std::uint64_t bytes = mesh.library->images[0].bytes.size();
  const SurfaceColor black = of(0, 0, 0);
  EXPECT_EQ(colors_of(mesh, {.any = 256, .per_byte = 0})[0], black);
  EXPECT_EQ(colors_of(mesh, {.any = 255, .per_byte = 0})[0], kUnknown);
  EXPECT_EQ(colors_of(mesh, {.any = 256 - bytes, .per_byte = 1})[0], black);
  EXPECT_EQ(colors_of(mesh, {.any = 255 - bytes, .per_byte = 1})[0], kUnknown);
  EXPECT_EQ(colors_of(mesh, {.most = 255})[0], kUnknown);
  EXPECT_EQ(colors_of(mesh, {.of_one = 255})[0], kUnknown);
}

}  // namespace
}  // namespace fracture
