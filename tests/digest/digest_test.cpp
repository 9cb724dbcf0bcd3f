#include "common/digest/digest.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/digest/running_digest.hpp"

namespace fracture {
namespace {

TEST(Sha256, MatchesTheExamplesOfFips180) {
  EXPECT_EQ(sha256("abc").hex(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("").hex(), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq").hex(),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Sha256, OfBytesAndOfTextAgree) {
  const std::string text("a\0b", 3);
  EXPECT_EQ(sha256(text), sha256(std::as_bytes(std::span(text.data(), text.size()))));
  EXPECT_NE(sha256(text), sha256("a"));
}

TEST(RunningDigest, DoesNotDependOnThePieces) {
  const std::string text = "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq";  // from FIPS 180
  for (const std::size_t size : {1u, 3u, 55u, 100u}) {
    RunningDigest digest;
    for (std::size_t at = 0; at < text.size(); at += size)
      digest.add(std::as_bytes(std::span(text).subspan(at, std::min(size, text.size() - at))));
    EXPECT_EQ(digest.finish().hex(), "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1")
        << size;
  }
  EXPECT_EQ(RunningDigest().finish(), sha256(""));
}

}  // namespace
}  // namespace fracture
