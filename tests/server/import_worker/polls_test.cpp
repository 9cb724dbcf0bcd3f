// How often the server polls while it takes over what an import worker has read.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "common/mesh/material_library.hpp"
#include "server/import_worker/mesh_codec.hpp"
#include "server/import_worker/shared_memory.hpp"
#include "tests/support/polls.hpp"

namespace fracture::test {
namespace {

Mesh mesh_of(std::size_t triangles) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles.assign(triangles, {0, 1, 2});
  mesh.material.assign(triangles, kNoIndex);
  mesh.node.assign(triangles, 0);
  mesh.node_names = {"node"};
  mesh.library = std::make_shared<const MaterialLibrary>();
  return mesh;
}

// Three arrays with 20 bytes for each triangle. Each is copied, and then checked.
TEST(ReplyPolls, AreOneForEachQuarterOfAMebibyteCopiedAndChecked) {
  constexpr std::size_t kTriangles = 400'000;
  const std::vector<std::byte> bytes = encode_reply(mesh_of(kTriangles));
  Polls polls;
  const Expected<Mesh> mesh = decode_reply(bytes, {}, polls.execution);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_EQ(mesh->triangles.size(), kTriangles);
  EXPECT_EQ(mesh->triangles.capacity(), kTriangles);
  EXPECT_GE(polls.count, static_cast<int>(2 * (20 * kTriangles >> 18)));
}

// The extras of each node are parsed, which takes some microseconds.
TEST(ReplyPolls, AreOneForEachFewHundredTexts) {
  constexpr int kNodes = 100'000;
  Mesh mesh = mesh_of(1);
  for (int k = 0; k < kNodes; ++k)
    mesh.empty_nodes.push_back({"n", {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {}, "\"k\":1"});
  const std::vector<std::byte> bytes = encode_reply(mesh);
  Polls polls;
  ASSERT_TRUE(decode_reply(bytes, {}, polls.execution));
  EXPECT_GE(polls.count, kNodes / 1000);
}

// The materials of a file are one text.
TEST(ReplyPolls, AreOneForEachFewHundredValuesOfJson) {
  constexpr int kMaterials = 50'000;
  Mesh mesh = mesh_of(1);
  MaterialLibrary library;
  for (int k = 0; k < kMaterials; ++k) library.materials.push_back(nlohmann::json::object({{"name", "m"}}));
  mesh.library = std::make_shared<const MaterialLibrary>(std::move(library));
  const std::vector<std::byte> bytes = encode_reply(mesh);
  Polls polls;
  ASSERT_TRUE(decode_reply(bytes, {}, polls.execution));
  EXPECT_GE(polls.count, kMaterials / 1000);
}

TEST(ReplyPolls, AReplyIsGivenUpHalfWay) {
  const std::vector<std::byte> bytes = encode_reply(mesh_of(400'000));
  Polls polls;
  polls.stop_at = 10;
  EXPECT_THROW((void)decode_reply(bytes, {}, polls.execution), Interrupted);
  EXPECT_EQ(polls.count, 10);
}

// A worker that keeps a writable mapping makes the server copy its reply.
TEST(ReplyPolls, ACopyPolls) {
  std::vector<std::byte> bytes(std::size_t{8} << 20);
  for (std::size_t k = 0; k < bytes.size(); ++k) bytes[k] = static_cast<std::byte>(k * k >> 3);
  const Descriptor memory = make_shared_memory("fracture-test");
  ASSERT_TRUE(write_all(memory.get(), bytes));
  void* const foreign = ::mmap(nullptr, bytes.size(), PROT_READ | PROT_WRITE, MAP_SHARED, memory.get(), 0);
  ASSERT_NE(foreign, MAP_FAILED);
  Polls polls;
  const SealedBytes taken = SealedBytes::take(memory.get(), bytes.size(), polls.execution);
  ::munmap(foreign, bytes.size());
  ASSERT_TRUE(taken.good());
  EXPECT_TRUE(std::ranges::equal(taken.view(), bytes));
  EXPECT_GE(polls.count, 32);
}

}  // namespace
}  // namespace fracture::test
