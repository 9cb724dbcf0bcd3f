#include "common/import/picture_heads.hpp"

#include <gtest/gtest.h>

#include <string>

namespace fracture {
namespace {

using namespace std::string_literals;

std::uint64_t largest(const std::string& bytes) { return largest_picture(std::as_bytes(std::span(bytes))); }

const std::string kPng = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x01\0\0\0\0\x80\x08\x06"s;  // 256 x 128
// A JFIF segment, followed by a progressive frame of 100 x 300.
const std::string kJpeg = "\xff\xd8\xff\xe0\0\x04zz\xff\xc2\0\x11\x08\0\x64\x01\x2c\x03"s;

TEST(PictureHeads, TheLargestCountsWhereverItStands) {
  EXPECT_EQ(largest(kPng), 256u * 128);
  EXPECT_EQ(largest(kJpeg), 100u * 300);
  EXPECT_EQ(largest("glTF...." + kJpeg + "...." + kPng + "...."), 256u * 128);
  EXPECT_EQ(largest("\xff\xff" + kJpeg), 100u * 300);
}

// Each of these is followed by all others as its segments.
TEST(PictureHeads, AMillionFalseHeadsTakeLinearTime) {
  std::string bytes;
  for (int k = 0; k < 1'000'000; ++k) bytes += "\xff\xd8\xff\0\0\4"s;
  EXPECT_EQ(largest(bytes), 0u);
}

int polls_of(const std::string& bytes) {
  int polls = 0;
  Execution execution;
  execution.watch = [&polls] { ++polls; };
  EXPECT_EQ(largest_picture(std::as_bytes(std::span(bytes)), execution), 0u);
  return polls;
}

// Two searches, each with a poll for each quarter of a mebibyte.
TEST(PictureHeads, AFloodOfFirstBytesPollsLikeAnyOtherFile) {
  constexpr std::size_t kSize = std::size_t{8} << 20;
  for (const char flood : {'a', '\x89', '\xff', '\n', '\xd8'}) {
    const int polls = polls_of(std::string(kSize, flood));
    EXPECT_GE(polls, 2 * 32) << static_cast<int>(flood);
    EXPECT_LE(polls, 2 * 33) << static_cast<int>(flood);
  }
}

// A million segments are skipped in all. Each may be anywhere in the file, so it takes longer than a byte of a search.
TEST(PictureHeads, SkippedSegmentsPollToo) {
  std::string bytes;
  for (int k = 0; k < 20'000; ++k) bytes += "\xff\xd8\xff\0\0\4"s;  // less than a quarter of a mebibyte
  EXPECT_GE(polls_of(bytes), 100);
}

TEST(PictureHeads, WithoutAHeadThereIsNone) {
  EXPECT_EQ(largest(""), 0u);
  EXPECT_EQ(largest("v 0 0 0\n"), 0u);
  EXPECT_EQ(largest(std::string(1000, '\xff')), 0u);
  EXPECT_EQ(largest(std::string(1000, '\x89')), 0u);
  for (std::size_t cut = 0; cut + 2 < kPng.size(); ++cut) EXPECT_EQ(largest(kPng.substr(0, cut)), 0u);
  for (std::size_t cut = 0; cut + 1 < kJpeg.size(); ++cut) EXPECT_EQ(largest(kJpeg.substr(0, cut)), 0u);
}

}  // namespace
}  // namespace fracture
