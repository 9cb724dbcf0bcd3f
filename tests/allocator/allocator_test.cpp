#include "common/allocator/allocator.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#if !defined(FRACTURE_SANITIZED)
#include <jemalloc/jemalloc.h>
#endif

#include "tests/support/eventually.hpp"

namespace fracture {
namespace {

constexpr std::uint64_t kMiB = 1u << 20, kUsed = 96 * kMiB;
constexpr const char* kLargePages = "/sys/kernel/mm/transparent_hugepage/enabled";

std::uint64_t resident() {
  std::uint64_t all = 0, pages = 0;
  std::ifstream("/proc/self/statm") >> all >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// Bytes of this process's memory that lie in large pages.
std::uint64_t in_large_pages() {
  std::ifstream rollup("/proc/self/smaps_rollup");
  std::string word;
  std::uint64_t kib = 0;
  while (rollup >> word)
    if (word == "AnonHugePages:") rollup >> kib;
  return kib * 1024;
}

/// Whether the system gives large pages to a program that asks for them.
bool large_pages_on_request() {
  std::string modes;
  std::getline(std::ifstream(kLargePages), modes);
  return modes.find("[madvise]") != std::string::npos || modes.find("[always]") != std::string::npos;
}

/// Allocates kUsed bytes in blocks of 2 KiB to 32 KiB, writes to them and frees them. Returns the resident
/// bytes just before the blocks are freed.
std::uint64_t use_and_free() {
  std::vector<std::unique_ptr<char[]>> blocks;
  std::uint64_t sum = 0;
  for (std::size_t size = 2048; sum < kUsed; size = size < 32768 ? 2 * size : 2048, sum += size) {
    blocks.push_back(std::make_unique_for_overwrite<char[]>(size));
    std::memset(blocks.back().get(), 1, size);
  }
  return resident();
}

class Allocator : public testing::Test {
 protected:
  void SetUp() override {
#if defined(FRACTURE_SANITIZED)
    GTEST_SKIP() << "the sanitizer's allocator";
#endif
    return_free_memory();
  }
};

#if !defined(FRACTURE_SANITIZED)
template <class Value>
Value setting(const char* name) {
  Value value{};
  std::size_t size = sizeof(value);
  EXPECT_EQ(mallctl(name, &value, &size, nullptr, 0), 0) << name;
  return value;
}

// jemalloc ignores names of settings that it does not know.
TEST_F(Allocator, ItsSettingsAreInForce) {
  // If the system has no large pages (for example gVisor), jemalloc asks for none.
  if (std::ifstream(kLargePages)) {
    EXPECT_STREQ(setting<const char*>("opt.thp"), "always");
  }
  EXPECT_STREQ(setting<const char*>("opt.metadata_thp"), "auto");
  EXPECT_EQ(setting<ssize_t>("opt.dirty_decay_ms"), 5000);
  EXPECT_EQ(setting<ssize_t>("opt.muzzy_decay_ms"), 0);
  EXPECT_EQ(setting<std::size_t>("opt.lg_extent_max_active_fit"), 30u);
  EXPECT_EQ(setting<std::size_t>("opt.oversize_threshold"), 32 * kMiB);
  EXPECT_LE(setting<unsigned>("opt.narenas"), std::max(1u, std::thread::hardware_concurrency()));
}
#endif

TEST_F(Allocator, WhatWasFreedIsKeptAndUsedAgain) {
  const std::uint64_t once = use_and_free();
  // On a slow machine not all memory is returned: jemalloc may treat memory freed just after a purge as older
  // than it is.
  EXPECT_GE(free_memory(), 16 * kMiB);
  for (int k = 0; k < 5; ++k) EXPECT_LE(use_and_free(), once + 24 * kMiB) << "of 96 MiB used again";
}

TEST_F(Allocator, GivesBackWhenAsked) {
  const std::uint64_t before = resident();
  use_and_free();
  EXPECT_GE(resident(), before + 16 * kMiB);
  return_free_memory();
  EXPECT_LE(free_memory(), 8 * kMiB);
  EXPECT_LE(resident(), before + 8 * kMiB);
}

TEST_F(Allocator, GivesBackWhatNobodyAskedForInSeconds) {
  use_and_free();
  return_old_free_memory();
  EXPECT_GE(free_memory(), 16 * kMiB) << "before it is old";
  EXPECT_TRUE(test::eventually(test::kPatience, "old free memory to go back", [] {
    return_old_free_memory();
    return free_memory() <= 8 * kMiB;
  }));
}

TEST_F(Allocator, PagesAreLarge) {
  if (!large_pages_on_request()) GTEST_SKIP() << "this system hands out no large pages on request";
  const std::uint64_t before = in_large_pages();
  const auto block = std::make_unique_for_overwrite<char[]>(64 * kMiB);
  std::memset(block.get(), 1, 64 * kMiB);
  EXPECT_GE(in_large_pages(), before + 16 * kMiB);  // only as many as are free in one piece
}

}  // namespace
}  // namespace fracture
