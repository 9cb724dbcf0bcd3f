// The memory that a bake takes for its own when nobody says it.
#include "server/bake/memory.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/server/temporary_folder.hpp"

namespace fracture::bake {
namespace {

constexpr std::uint64_t kNoLimit = ~std::uint64_t{0};

TEST(MemoryLimitOfGroup, IsTheLeastOfTheGroupAndThoseAboveIt) {
  const test::TemporaryFolder root;
  std::filesystem::create_directories(root / "a/b");
  std::filesystem::create_directories(root / "memory/c");
  const auto limit = [&](const std::string& membership) {
    return memory_limit_of_group(membership, root.path);
  };
  EXPECT_EQ(limit("0::/a/b\n"), kNoLimit) << "no files: no limit";
  root.write("a/b/memory.max", "max\n");
  EXPECT_EQ(limit("0::/a/b\n"), kNoLimit);
  root.write("a/memory.max", "2147483648\n");
  EXPECT_EQ(limit("0::/a/b\n"), 2147483648u) << "of the group above";
  root.write("a/b/memory.max", "1073741824\n");
  EXPECT_EQ(limit("0::/a/b\n"), 1073741824u);
  EXPECT_EQ(limit("0::/a\n"), 2147483648u) << "not of those below";
  root.write("memory.max", "5000000\n");
  EXPECT_EQ(limit("0::/elsewhere/x\n"), 5000000u) << "in a container the root is the own group";
  root.write("memory/c/memory.limit_in_bytes", "300\n");
  EXPECT_EQ(limit("5:cpu:/c\n4:blkio,memory:/c\n"), 300u);
  EXPECT_EQ(limit("5:cpu:/c\nnonsense\n"), kNoLimit);
}

TEST(AvailableMemory, IsSomeOfThisMachine) {
  EXPECT_GT(available_memory(), 1u << 20);
  EXPECT_LT(available_memory(), 1ull << 60);
}

}  // namespace
}  // namespace fracture::bake
