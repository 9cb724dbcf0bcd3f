#include "common/base/pages.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <memory>
#include <vector>

namespace fracture::test {
namespace {

/// Bytes of this process that are in memory.
std::size_t resident() {
  std::size_t all = 0, here = 0;
  std::ifstream("/proc/self/statm") >> all >> here;
  return here * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

TEST(ForgetPages, GivesMemoryBackThatIsStillAllocated) {
  constexpr std::size_t kSize = std::size_t{64} << 20;
  std::vector<char> memory(kSize, 1);
  const std::size_t before = resident();
  forget_pages(memory.data() + 1, kSize - 2);
  EXPECT_LT(resident() + 9 * kSize / 10, before);
  EXPECT_EQ(memory.front(), 1) << "not all of its page is forgotten";
  EXPECT_EQ(memory.back(), 1);
  memory.assign(kSize, 2);
  EXPECT_EQ(memory[kSize / 2], 2);
}

TEST(ForgetPages, LessThanAPageStays) {
  std::vector<char> memory(1000, 1);
  forget_pages(memory.data(), memory.size());
  EXPECT_EQ(memory, std::vector<char>(1000, 1));
  forget_pages(nullptr, 0);
}

TEST(PagesBehind, GoAndNothingElseDoes) {
  constexpr std::size_t kMiB = std::size_t{1} << 20, kStep = 300'000;
  // kRead ends so far before the end of a piece that the reader's last step passes the end of the piece.
  constexpr std::size_t kRead = 36 * kMiB - 100'000, kAll = 40 * kMiB;
  std::vector<char> memory(kAll, 1);
  const std::size_t before = resident();
  PagesBehind behind(memory.data(), kRead);
  for (std::size_t at = 0; at < kRead; at += kStep) {
    ASSERT_EQ(memory[at], 1) << "not read yet";
    behind.through(at + kStep);
  }
  EXPECT_LT(resident() + 28 * kMiB, before);
  EXPECT_EQ(std::count(memory.begin() + kRead, memory.end(), 1), static_cast<std::ptrdiff_t>(kAll - kRead));
}

TEST(PagesBehind, GoWithThoseThatTwoPiecesShare) {
  constexpr std::size_t kAll = std::size_t{40} << 20;
  std::vector<char> memory(kAll + 100, 1);
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  char* begin = memory.data();
  if (reinterpret_cast<std::uintptr_t>(begin) % page == 0) begin += 16;
  PagesBehind(begin, kAll).through(kAll);
  const std::uintptr_t first = (reinterpret_cast<std::uintptr_t>(begin) + page - 1) / page * page;
  std::vector<unsigned char> in_memory(kAll / page - 1);
  ASSERT_EQ(mincore(reinterpret_cast<void*>(first), in_memory.size() * page, in_memory.data()), 0);
  EXPECT_EQ(std::count_if(in_memory.begin(), in_memory.end(), [](unsigned char p) { return (p & 1) != 0; }),
            0);
}

TEST(PagesBehind, StayWhereTheyAreFew) {
  std::vector<char> memory(std::size_t{31} << 20, 1);
  PagesBehind(memory.data(), memory.size()).through(memory.size());
  EXPECT_EQ(std::count(memory.begin(), memory.end(), 1), static_cast<std::ptrdiff_t>(memory.size()));
}

TEST(PopulatePages, HandsOutMemoryBeforeItIsWritten) {
  constexpr std::size_t kSize = std::size_t{64} << 20;
  const std::unique_ptr<char[]> memory(new char[kSize]);  // never written to
  memory[7] = 3;
  if (madvise(memory.get() + (4096 - reinterpret_cast<std::uintptr_t>(memory.get()) % 4096), 4096,
              MADV_POPULATE_WRITE) != 0)
    GTEST_SKIP() << "Linux has this since 5.14";
  const std::size_t before = resident();
  populate_pages(memory.get(), kSize);
  EXPECT_GT(resident(), before + 9 * kSize / 10);
  EXPECT_EQ(memory[7], 3);
  populate_pages(nullptr, 0);
}

}  // namespace
}  // namespace fracture::test
