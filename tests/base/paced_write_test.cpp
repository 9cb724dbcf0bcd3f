#include "common/base/paced_write.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <vector>

namespace fracture {
namespace {

std::vector<std::byte> numbered(std::size_t size) {
  std::vector<std::byte> bytes(size);
  for (std::size_t k = 0; k < size; ++k) bytes[k] = static_cast<std::byte>(k * 7 + k / 251);
  return bytes;
}

TEST(PacedWrite, WritesAllBytesInOrder) {
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{5}, kWritePieceBytes, 2 * kWritePieceBytes + 3}) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), std::fclose);
    ASSERT_TRUE(file);
    const std::vector<std::byte> bytes = numbered(size);
    ASSERT_TRUE(write_paced(::fileno(file.get()), bytes));
    std::vector<std::byte> read(size + 1);
    EXPECT_EQ(::pread(::fileno(file.get()), read.data(), read.size(), 0), static_cast<ssize_t>(size));
    read.resize(size);
    EXPECT_EQ(read, bytes);
  }
}

TEST(PacedWrite, WritesToAPipeWhichHasNoPosition) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const Descriptor in(ends[0]), out(ends[1]);
  const std::vector<std::byte> bytes = numbered(1000);
  ASSERT_TRUE(write_paced(out.get(), bytes));
  std::vector<std::byte> read(1000);
  EXPECT_EQ(::read(in.get(), read.data(), read.size()), 1000);
  EXPECT_EQ(read, bytes);
}

TEST(PacedWrite, ReportsAFullDisk) {
  const Descriptor full(::open("/dev/full", O_WRONLY | O_CLOEXEC));
  if (!full) GTEST_SKIP() << "no /dev/full";
  EXPECT_FALSE(write_paced(full.get(), numbered(kWritePieceBytes + 1)));
}

}  // namespace
}  // namespace fracture
