// The positions of the contents of a buffer, and that they are written there with any number of threads.
#include "common/gltf/buffer_contents.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <span>
#include <vector>

#include "common/gltf/vertex_data.hpp"
#include "tests/support/polls.hpp"

namespace fracture::test {
namespace {

/// `count` bytes of one value.
struct Filled {
  std::uint8_t value;
  std::size_t count;
};
void write_run(const Filled& run, std::span<std::uint8_t> out, Pacer&) {
  EXPECT_EQ(out.size(), run.count);
  std::fill(out.begin(), out.end(), run.value);
}

std::vector<std::uint8_t> written(const BufferContents& contents, int threads = 1) {
  std::vector<std::uint8_t> buffer(contents.size());
  Execution execution;
  execution.threads = threads;
  contents.write(buffer.data(), execution);
  return buffer;
}

TEST(BufferContents, ViewsFollowOneAnotherAndEachPieceBeginsAtAMultipleOfFour) {
  BufferContents contents;
  const Filled five{5, 5}, two{2, 2}, three{3, 3};
  const std::size_t first = contents.view("first", 12, kArrayBuffer);
  EXPECT_EQ(contents.put<write_run>(first, 5, five), 0u);
  const std::size_t second = contents.view("second", 0, 0);
  EXPECT_EQ(contents.put<write_run>(second, 3, three), 0u);
  EXPECT_EQ(contents.view("first", 12, kArrayBuffer), first);
  EXPECT_EQ(contents.put<write_run>(first, 2, two), 8u);

  ASSERT_EQ(contents.views().size(), 2u);
  EXPECT_EQ(contents.views()[first].size, 10u);  // without the padding after it
  EXPECT_EQ(contents.views()[second].size, 3u);
  EXPECT_EQ(written(contents), (std::vector<std::uint8_t>{5, 5, 5, 5, 5, 0, 0, 0, 2, 2, 0, 0, 3, 3, 3, 0}));
}

TEST(BufferContents, WhatIsNextLeavesNoGap) {
  BufferContents contents;
  const Filled five{5, 5}, two{2, 2};
  const std::size_t view = contents.view("image", 0, 0);
  EXPECT_EQ(contents.put<write_run>(view, 5, five, /*next=*/true), 0u);
  EXPECT_EQ(contents.put<write_run>(view, 2, two, /*next=*/true), 5u);
  EXPECT_EQ(written(contents), (std::vector<std::uint8_t>{5, 5, 5, 5, 5, 2, 2, 0}));
}

TEST(BufferContents, TheSameBytesFromAnyNumberOfThreads) {
  BufferContents contents;
  std::deque<Filled> runs;
  const std::size_t views[] = {contents.view("a", 0, 0), contents.view("b", 0, 0)};
  for (std::size_t k = 0; k < 3000; ++k) {
    const Filled& run = runs.emplace_back(Filled{static_cast<std::uint8_t>(k % 251 + 1), k % 1000 + 1});
    contents.put<write_run>(views[k % 2], run.count, run);
  }
  const std::vector<std::uint8_t> one = written(contents);
  EXPECT_GT(one.size(), 1u << 20);
  for (const int threads : {2, 3, 8}) EXPECT_EQ(written(contents, threads), one) << threads;
}

TEST(BufferContents, WritingCanBeInterruptedInTheMiddleOfAPiece) {
  BufferContents contents;
  const std::vector<std::uint8_t> bytes(8u << 20, 7);
  contents.put<write_bytes>(contents.view("a", 0, 0), bytes.size(), bytes.front());
  Polls polls(5);
  std::vector<std::uint8_t> buffer(contents.size());
  EXPECT_THROW(contents.write(buffer.data(), polls.execution), Interrupted);
  EXPECT_EQ(buffer.front(), 7);
  EXPECT_EQ(buffer.back(), 0);
}

}  // namespace
}  // namespace fracture::test
