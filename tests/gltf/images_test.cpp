// Images of the source in the answer: without the chunks that glTF ignores, otherwise unchanged.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/gltf/gltf_writer.hpp"
#include "common/mesh/material_library.hpp"
#include "tests/gltf/glb_file.hpp"
#include "tests/gltf/two_halves.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

/// A PNG made of chunks. Its checksums are not read.
std::vector<std::uint8_t> png(const std::vector<std::pair<std::string, std::vector<std::uint8_t>>>& chunks) {
  std::vector<std::uint8_t> bytes = {0x89, 'P', 'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a};
  for (const auto& [type, data] : chunks) {
    for (const int shift : {24, 16, 8, 0}) bytes.push_back(static_cast<std::uint8_t>(data.size() >> shift));
    bytes.insert(bytes.end(), type.begin(), type.end());
    bytes.insert(bytes.end(), data.begin(), data.end());
    bytes.insert(bytes.end(), {1, 2, 3, 4});
  }
  return bytes;
}

std::vector<std::uint8_t> image_in_file(const std::vector<std::uint8_t>& bytes) {
  FracturedSolid made = two_halves();
  auto library = std::make_shared<MaterialLibrary>(*made.set.source->library);
  library->images[0].bytes = bytes;
  auto mesh = std::make_shared<Mesh>(*made.set.source);
  mesh->library = library;
  made.set.source = mesh;
  const Glb glb(write_glb(made, {}));
  const json& view = glb.document["bufferViews"][glb.document["images"][0]["bufferView"].get<std::size_t>()];
  const auto first = glb.binary.begin() + view["byteOffset"].get<std::ptrdiff_t>();
  return {first, first + view["byteLength"].get<std::ptrdiff_t>()};
}

TEST(Images, LoseTheChunksGltfIgnoresAndNothingElse) {
  const std::vector<std::uint8_t> header(13, 7), gamma_2 = {0, 0, 0xb1, 0x8f}, gamma_1 = {0, 1, 0x86, 0xa0};
  const std::vector<std::uint8_t> square = {0, 0, 11, 19, 0, 0, 11, 19, 1},
                                  tall = {0, 0, 11, 19, 0, 0, 11, 20, 1};
  const auto kept = png({{"IHDR", header},
                         {"zTXt", {9, 9}},
                         {"gAMA", gamma_2},
                         {"pHYs", square},
                         {"sRGB", {0}},
                         {"IDAT", {5, 6}},
                         {"iCCP", {8}},
                         {"IEND", {}}});
  EXPECT_EQ(image_in_file(kept), kept);
  EXPECT_EQ(image_in_file(png({{"IHDR", header},
                               {"iCCP", {1, 2, 3}},
                               {"gAMA", gamma_1},
                               {"PLTE", {1}},
                               {"cHRM", std::vector<std::uint8_t>(32, 1)},
                               {"pHYs", tall},
                               {"IDAT", {5, 6}},
                               {"IEND", {}}})),
            png({{"IHDR", header}, {"PLTE", {1}}, {"IDAT", {5, 6}}, {"IEND", {}}}));
}

TEST(Images, ThatCannotBeFollowedPassThrough) {
  auto cut = png({{"IHDR", std::vector<std::uint8_t>(13, 7)}, {"iCCP", std::vector<std::uint8_t>(40, 1)}});
  cut.resize(cut.size() - 20);
  EXPECT_EQ(image_in_file(cut), cut);
  const std::vector<std::uint8_t> jpeg = {0xff, 0xd8, 0xff, 0xe2, 1, 2};
  EXPECT_EQ(image_in_file(jpeg), jpeg);
}

}  // namespace
}  // namespace fracture::test
