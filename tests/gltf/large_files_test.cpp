// Files of hundreds of megabytes. The same rules hold, and no work grows faster than the written bytes.
#include <gtest/gtest.h>

#include <cmath>
#include <stop_token>
#include <string>

#include "common/gltf/accessors.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "common/mesh/material_library.hpp"
#include "tests/gltf/glb_file.hpp"
#include "tests/gltf/two_halves.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/poll_gaps.hpp"

namespace fracture::test {
namespace {

/// A band of 2 n triangles between two edges of n vertices, with normals and UVs.
Fragment band(std::uint32_t n) {
  Fragment f;
  f.attributes.uvs.resize(1);
  for (std::uint32_t k = 0; k < 2 * n; ++k) {
    const float angle = static_cast<float>(k / 2) / static_cast<float>(n);
    f.positions.push_back({angle, angle * angle, k % 2 == 0 ? 0.f : 1.f});
    f.attributes.normals.push_back({1, 0, 0});
    f.attributes.uvs[0].push_back({angle, 0.5f});
    f.topology.push_back(k);
  }
  for (std::uint32_t k = 0; k < 2 * n; ++k) {
    const std::uint32_t a = k, b = (k + 1) % (2 * n), c = (k + 2) % (2 * n);
    for (const std::uint32_t v : {a, k % 2 == 0 ? b : c, k % 2 == 0 ? c : b}) f.indices.push_back(v);
  }
  f.primitives.push_back({kNoIndex, 0, static_cast<std::uint32_t>(f.indices.size())});
  f.mass.volume = 1;
  f.mass.inertia = {1, 1, 1, 0, 0, 0};
  return f;
}

/// Many copies of the second half, each with its own id.
FracturedSolid many_halves(std::size_t count) {
  FracturedSolid made = two_halves_with_hulls();
  const Fragment one = made.set.fragments[1];
  const Bond bond = made.set.bonds[0];
  made.set.fragments.assign(count, one);
  made.hulls.of_fragment.assign(count, made.hulls.of_fragment[1]);
  for (std::size_t k = 0; k < count; ++k) {
    made.set.fragments[k].id = k;
    made.set.fragments[k].sites = {SiteId{k}};
  }
  made.set.bonds.assign(3 * count, bond);
  return made;
}

TEST(LargeFiles, HaveWhatWasGivenOverAllTheBlocksTheyAreWrittenIn) {
  FracturedSolid made = two_halves();
  made.set.fragments[0] = band(sized(50'000u, 150'000u));
  const std::vector<std::uint8_t> file = write_glb(made, {});
  const Glb glb(file);
  const auto& primitive = glb.document["meshes"][0]["primitives"][0];
  EXPECT_EQ(glb.read<Vec3f>(primitive["attributes"]["POSITION"]), made.set.fragments[0].positions);
  EXPECT_EQ(glb.read<Vec3f>(primitive["attributes"]["NORMAL"]), made.set.fragments[0].attributes.normals);
  EXPECT_EQ(glb.read<Vec2f>(primitive["attributes"]["TEXCOORD_0"]), made.set.fragments[0].attributes.uvs[0]);
  EXPECT_EQ(glb.read<std::uint32_t>(primitive["indices"]), made.set.fragments[0].indices);
  const auto& second = glb.document["meshes"][1]["primitives"][0];
  EXPECT_EQ(glb.read<Vec3f>(second["attributes"]["POSITION"]), made.set.fragments[1].positions);

  // The same bytes in the other container, decoded by hand.
  const std::vector<std::uint8_t> text = write_gltf(made, {});
  const auto document = nlohmann::json::parse(text);
  const std::string uri = document["buffers"][0]["uri"];
  const std::string data = uri.substr(uri.find(',') + 1);
  std::vector<std::uint8_t> decoded;
  const auto digit = [](char c) {
    return c == '/'   ? 63u
           : c == '+' ? 62u
           : c <= '9' ? static_cast<unsigned>(c - '0') + 52
           : c <= 'Z' ? static_cast<unsigned>(c - 'A')
                      : static_cast<unsigned>(c - 'a') + 26;
  };
  for (std::size_t k = 0; k + 3 < data.size(); k += 4) {
    unsigned bits = 0;
    for (std::size_t d = 0; d < 4; ++d) bits = bits << 6 | (data[k + d] == '=' ? 0 : digit(data[k + d]));
    for (const int shift : {16, 8, 0}) decoded.push_back(static_cast<std::uint8_t>(bits >> shift));
  }
  decoded.resize(document["buffers"][0]["byteLength"].get<std::size_t>());
  EXPECT_EQ(decoded, glb.binary);
}

TEST(LargeFiles, MergeCornersByNumbersOf32Bits) {
  FracturedSolid made = two_halves();
  Fragment& f = made.set.fragments[0] = band(150'000);
  f.topology[299'999] = 150'001;
  f.topology[299'998] = 3;
  std::vector<std::uint32_t> corners, vertices;
  for (std::uint32_t k = 0; k < f.indices.size(); ++k)
    if (f.indices[k] >= 299'998) {
      corners.push_back(k);
      vertices.push_back(f.indices[k] == 299'999 ? 150'001 : 3);
    }
  ASSERT_GT(corners.back(), kMaxShortVertices);
  const Glb glb(write_glb(made, {}));
  const auto& extension = glb.document["meshes"][0]["extensions"]["EXT_mesh_manifold"];
  EXPECT_EQ(glb.read<std::uint32_t>(extension["mergeIndices"]), corners);
  EXPECT_EQ(glb.read<std::uint32_t>(extension["mergeValues"]), vertices);
}

TEST(LargeFiles, CanBeInterruptedAnywhere) {
  FracturedSolid few = two_halves();
  few.set.fragments[0] = band(sized(150'000u, 600'000u));
  FracturedSolid many = many_halves(sized(4'000u, 15'000u));
  for (const FracturedSolid& made : {few, many})
    for (const auto write : {write_glb, write_gltf}) {
      std::vector<std::uint8_t> file;
      const Polled written =
          polled([&, &made = made](const Execution& execution) { file = write(made, {}, execution); });
      EXPECT_LT(written.longest_ms, kMostPollGapMs) << made.set.fragments.size() << " fragments";
      EXPECT_GT(file.size(), sized(10'000'000u, 40'000'000u));
      EXPECT_GT(written.polls, sized(20u, 100u));
    }
}

TEST(LargeFiles, AnInterruptionStopsTheWriting) {
  const FracturedSolid made = many_halves(300);
  PollGaps counted;
  write_glb(made, {}, counted.execution());
  ASSERT_GT(counted.polls(), 3u);
  // Stops at each poll in turn, up to the last.
  for (std::uint64_t stop = 1; stop <= counted.polls(); stop += 1 + counted.polls() / 20) {
    std::stop_source source;
    std::uint64_t polls = 0;
    Execution execution;
    execution.stop = source.get_token();
    execution.watch = [&] {
      if (++polls == stop) source.request_stop();
    };
    EXPECT_THROW(write_glb(made, {}, execution), Interrupted);
    EXPECT_EQ(polls, stop);
  }
}

// Formerly each of these normals searched for its triangle from the first triangle on.
TEST(LargeFiles, NormalsWithoutDirectionAreThoseOfTheFirstTriangleThatHasOne) {
  Fragment f = band(40'000);
  for (Vec3f& n : f.attributes.normals) n = {0, 0, 0};
  // At the first vertices all triangles but one are flat.
  for (std::uint32_t k = 0; k < 6; ++k) f.positions[k] = {0, 0, k % 2 == 0 ? 0.f : 1.f};
  FracturedSolid made = two_halves();
  made.set.fragments[0] = f;
  const Glb glb(write_glb(made, {}));
  const auto normals = glb.read<Vec3f>(glb.document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"]);
  ASSERT_EQ(normals.size(), f.positions.size());
  for (const std::size_t v : {0u, 1u, 2u, 3u, 5u, 1000u, 79'999u}) {
    Vec3d expected{0, 0, 1};
    for (std::size_t k = 0; k < f.indices.size(); k += 3) {
      const std::uint32_t* i = &f.indices[k];
      if (i[0] != v && i[1] != v && i[2] != v) continue;
      const Vec3d a = to_double(f.positions[i[0]]);
      const Vec3d n = cross(to_double(f.positions[i[1]]) - a, to_double(f.positions[i[2]]) - a);
      if (!(length(n) > 1e-30)) continue;
      expected = (1 / length(n)) * n;
      break;
    }
    EXPECT_NEAR(dot(to_double(normals[v]), expected), 1, 1e-6) << v;
  }
}

// Nodes with one name. Formerly the n-th node looked at all numbers given to the nodes before it.
TEST(LargeFiles, WholeNodesOfOneNameAreNumberedInTheirOrder) {
  FracturedSolid made = two_halves();
  auto mesh = std::make_shared<Mesh>(*made.set.source);
  auto rest = std::make_shared<Mesh>();
  rest->positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::uint32_t nodes_left = sized(2'000u, 20'000u);
  for (std::uint32_t node = 0; node < nodes_left; ++node) {
    rest->triangles.push_back({0, 1, 2});
    rest->material.push_back(kNoIndex);
    rest->node.push_back(node);
    rest->node_names.emplace_back(node == 7 ? "crate_5" : "crate");
  }
  mesh->passed_through = rest;
  made.set.source = mesh;
  const Glb glb(write_glb(made, {}));
  const auto& nodes = glb.document["nodes"];
  ASSERT_EQ(nodes.size(), 3 + nodes_left);
  EXPECT_EQ(nodes[3]["name"], "crate");
  EXPECT_EQ(nodes[4]["name"], "crate_2");
  EXPECT_EQ(nodes[7]["name"], "crate_5");
  EXPECT_EQ(nodes[10]["name"], "crate_5_2");  // its own name, and that number was already taken
  EXPECT_EQ(nodes[11]["name"], "crate_8");
  EXPECT_EQ(nodes[2 + nodes_left]["name"], "crate_" + std::to_string(nodes_left - 1));
}

TEST(LargeFiles, ClustersGetTheLowestNumberThatNoNodeBeginsWith) {
  FracturedSolid made = two_halves();
  auto mesh = std::make_shared<Mesh>(*made.set.source);
  constexpr int kTaken = 20'000;
  mesh->node_names.emplace_back("Cluster_of_rocks");
  for (int k = kTaken; k > 1; --k)
    if (k != 9000) mesh->node_names.push_back("Cluster" + std::to_string(k) + "_");
  made.set.source = mesh;
  made.hierarchy.levels.resize(1);
  made.hierarchy.levels[0].clusters.resize(1);
  made.hierarchy.levels[0].clusters[0].parent = kNoIndex;
  made.hierarchy.cluster_of_fragment = {0, 0};
  const Glb glb(write_glb(made, {}));
  EXPECT_EQ(glb.document["nodes"].back()["name"], "Cluster9000_0_0");
}

// One view for each image. Formerly it was found by comparing its name with those of all views before it.
TEST(LargeFiles, ManyImagesHaveAViewEach) {
  FracturedSolid made = two_halves();
  auto mesh = std::make_shared<Mesh>(*made.set.source);
  auto library = std::make_shared<MaterialLibrary>(*mesh->library);
  const std::size_t count = sized(3'000u, 30'000u);
  library->images.resize(count, library->images.at(0));
  for (std::size_t k = 0; k < count; ++k)
    library->images[k].bytes = {static_cast<std::uint8_t>(k), static_cast<std::uint8_t>(k >> 8), 7};
  mesh->library = library;
  made.set.source = mesh;
  const Glb glb(write_glb(made, {}));
  const auto& images = glb.document["images"];
  ASSERT_EQ(images.size(), count);
  for (const std::size_t k : {std::size_t{0}, std::size_t{1}, count - 1}) {
    const auto& view = glb.document["bufferViews"].at(images[k]["bufferView"].get<std::size_t>());
    EXPECT_EQ(view["byteLength"], 3);
    const std::size_t at = view["byteOffset"];
    EXPECT_EQ(glb.binary[at] | glb.binary[at + 1] << 8, static_cast<int>(k));
  }
}

}  // namespace
}  // namespace fracture::test
