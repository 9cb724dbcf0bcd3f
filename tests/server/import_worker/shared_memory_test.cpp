// The server reads what the worker wrote, whatever the worker does afterwards.
#include "server/import_worker/shared_memory.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <vector>

namespace fracture::test {
namespace {

std::vector<std::byte> numbered(std::size_t size) {
  std::vector<std::byte> bytes(size);
  for (std::size_t k = 0; k < size; ++k) bytes[k] = static_cast<std::byte>(k * k >> 3);
  return bytes;
}

Descriptor memory_with(const std::vector<std::byte>& bytes) {
  Descriptor memory = make_shared_memory("fracture-test");
  EXPECT_EQ(::write(memory.get(), bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  return memory;
}

class SealedBytesOf : public testing::TestWithParam<std::size_t> {};

TEST_P(SealedBytesOf, AreWhatWasWritten) {
  const std::vector<std::byte> bytes = numbered(GetParam());
  const Descriptor memory = memory_with(bytes);
  const SealedBytes taken = SealedBytes::take(memory.get(), bytes.size());
  ASSERT_TRUE(taken.good());
  EXPECT_TRUE(std::ranges::equal(taken.view(), bytes));
  EXPECT_FALSE(SealedBytes::take(memory.get(), bytes.size() + 1).good()) << "more than there is";
}

TEST_P(SealedBytesOf, StayWhatTheyWere) {
  const std::vector<std::byte> bytes = numbered(GetParam());
  if (bytes.empty()) return;
  const Descriptor memory = memory_with(bytes);
  void* const foreign = ::mmap(nullptr, bytes.size(), PROT_READ | PROT_WRITE, MAP_SHARED, memory.get(), 0);
  ASSERT_NE(foreign, MAP_FAILED);
  const SealedBytes taken = SealedBytes::take(memory.get(), bytes.size());
  static_cast<std::byte*>(foreign)[bytes.size() - 1] ^= std::byte{255};
  ASSERT_TRUE(taken.good());
  EXPECT_TRUE(std::ranges::equal(taken.view(), bytes)) << "somebody could still write";
  ::munmap(foreign, bytes.size());
}

TEST_P(SealedBytesOf, MoveToAnotherOwner) {
  const std::vector<std::byte> bytes = numbered(GetParam());
  const Descriptor memory = memory_with(bytes);
  SealedBytes taken = SealedBytes::take(memory.get(), bytes.size());
  const SealedBytes owner = std::move(taken);
  EXPECT_TRUE(owner.good());
  EXPECT_TRUE(std::ranges::equal(owner.view(), bytes));
}

INSTANTIATE_TEST_SUITE_P(Sizes, SealedBytesOf, testing::Values(0, 1, 4096, 1'000'000));

/// Without address space for a mapping, the bytes are copied into memory that the program already has.
TEST(SealedBytesWithoutRoom, AreCopied) {
#if defined(FRACTURE_SANITIZED)
  GTEST_SKIP() << "the sanitizers reserve terabytes";
#endif
  const std::vector<std::byte> bytes = numbered(50'000);
  const Descriptor memory = memory_with(bytes);
  numbered(100'000);  // memory that the program keeps
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_AS, &before), 0);
  const rlimit none{1 << 20, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &none), 0);
  const SealedBytes taken = SealedBytes::take(memory.get(), bytes.size());
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &before), 0);
  ASSERT_TRUE(taken.good());
  EXPECT_TRUE(std::ranges::equal(taken.view(), bytes));
}

}  // namespace
}  // namespace fracture::test
