// The limits of a control group, read from the files that the kernel writes.
#include "server/service/control_group.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/server/support/temporary_folder.hpp"

namespace fracture {
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

TEST(CoresOfGroup, AreTheLeastQuotaOfTheGroupAndThoseAboveIt) {
  const test::TemporaryFolder root;
  std::filesystem::create_directories(root / "a/b");
  std::filesystem::create_directories(root / "cpu/c");
  const auto cores = [&](const std::string& membership) { return cores_of_group(membership, root.path); };
  EXPECT_EQ(cores("0::/a/b\n"), 0) << "no files: no quota";
  root.write("a/b/cpu.max", "max 100000\n");
  EXPECT_EQ(cores("0::/a/b\n"), 0);
  root.write("a/cpu.max", "150000 100000\n");
  EXPECT_EQ(cores("0::/a/b\n"), 1.5) << "of the group above: a service within a slice";
  root.write("a/b/cpu.max", "50000 100000\n");
  EXPECT_EQ(cores("0::/a/b\n"), 0.5);
  root.write("cpu/c/cpu.cfs_quota_us", "-1\n");
  root.write("cpu/c/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(cores("4:cpu,cpuacct:/c\n"), 0);
  root.write("cpu/c/cpu.cfs_quota_us", "300000\n");
  EXPECT_EQ(cores("4:cpu,cpuacct:/c\n"), 3);
}

TEST(Available, IsSomeOfThisMachine) {
  EXPECT_GT(available_memory(), 1u << 20);
  EXPECT_LT(available_memory(), 1ull << 60);
  EXPECT_GE(available_cores(), 1);
}

}  // namespace
}  // namespace fracture
