// Signatures of entries in shared cache tiers: an entry is accepted only if the farm signed it, and only as
// what it was signed for.
#include "server/cache/farm_keys.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/digest/digest.hpp"
#include "tests/server/support/temporary_folder.hpp"

namespace fracture {
namespace {

using testing::HasSubstr;
using testing::Not;
using Bytes = std::vector<std::uint8_t>;

const std::string kOld(64, 'a'), kNew(64, 'b');
const SignedAs kHere{"redis", "0123abcd", 6};

FarmKeys keys_of(const std::string& text) {
  auto keys = FarmKeys::parse(text);
  if (!keys) throw std::runtime_error(keys.error().detail);
  return std::move(*keys);
}

Bytes signed_by(const FarmKeys& keys, const SignedAs& as, const Bytes& bytes) {
  const std::string head = keys.head(as, {std::span(bytes)});
  Bytes stored(head.begin(), head.end());
  stored.insert(stored.end(), bytes.begin(), bytes.end());
  return stored;
}

/// HMAC as RFC 2104 defines it, with our SHA-256.
Digest hmac(std::string key, const std::string& text) {
  key.resize(64, '\0');  // Our keys are not longer than a block.
  std::string inner = key, outer = key;
  for (char& c : inner) c = static_cast<char>(c ^ 0x36);
  for (char& c : outer) c = static_cast<char>(c ^ 0x5c);
  const Digest first = sha256(inner + text);
  return sha256(outer + std::string(first.bytes.begin(), first.bytes.end()));
}

TEST(FarmKeys, TheHeadIsTheHmacOfWhatTheHeaderSays) {
  const Bytes bytes = {1, 2, 3};
  const Digest right = hmac(kOld, "fracture cache entry\nredis\n0123abcd\n6\n\x01\x02\x03");
  EXPECT_EQ(keys_of(kOld).head(kHere, {std::span(bytes).first(1), std::span(bytes).last(2)}),
            "FRS1" + std::string(right.bytes.begin(), right.bytes.end()));
}

TEST(FarmKeys, OnlyWhatWasSignedAsThisIsOpened) {
  const FarmKeys keys = keys_of(kOld);
  const Bytes bytes = {1, 2, 3};
  const Bytes stored = signed_by(keys, kHere, bytes);
  const auto opened = keys.open(kHere, stored);
  ASSERT_TRUE(opened);
  EXPECT_TRUE(std::equal(opened->begin(), opened->end(), bytes.begin(), bytes.end()));
  EXPECT_FALSE(keys.open({"disk", kHere.key, kHere.algorithm}, stored)) << "another tier";
  EXPECT_FALSE(keys.open({kHere.tier, "0123abce", kHere.algorithm}, stored)) << "another key";
  EXPECT_FALSE(keys.open({kHere.tier, kHere.key, 7}, stored)) << "another algorithm";
  EXPECT_FALSE(keys_of(kNew).open(kHere, stored)) << "another farm";
  EXPECT_FALSE(keys.open(kHere, bytes)) << "not signed";
  EXPECT_FALSE(FarmKeys().open(kHere, stored)) << "no key";
  for (std::size_t k = 0; k < stored.size(); ++k) {
    Bytes changed = stored;
    changed[k] ^= 1;
    EXPECT_FALSE(keys.open(kHere, changed)) << k;
    EXPECT_FALSE(keys.open(kHere, std::span(stored).first(k))) << k;
  }
}

TEST(FarmKeys, AKeyIsChangedInThreeStepsWithoutLosingAnEntry) {
  const FarmKeys before = keys_of(kOld), prepared = keys_of(kOld + "\n" + kNew),
                 changed = keys_of(kNew + "\n" + kOld), after = keys_of(kNew);
  const Bytes bytes = {9};
  EXPECT_TRUE(prepared.open(kHere, signed_by(before, kHere, bytes)));
  EXPECT_TRUE(prepared.open(kHere, signed_by(changed, kHere, bytes)));
  EXPECT_TRUE(changed.open(kHere, signed_by(prepared, kHere, bytes)));
  EXPECT_TRUE(after.open(kHere, signed_by(changed, kHere, bytes)));
  EXPECT_FALSE(after.open(kHere, signed_by(prepared, kHere, bytes)));
}

TEST(FarmKeys, FilesAreReadStrictlyAndNeverQuoted) {
  const std::pair<std::string, const char*> wrong[] = {{"", "no key"},
                                                       {"# a comment\n\n", "no key"},
                                                       {"hunter2hunter2\n", "line 1"},
                                                       {kOld + "\nhunter2hunter2", "line 2"},
                                                       {kOld + "\n" + kNew + "\n" + kOld, "third key"}};
  for (const auto& [text, message] : wrong) {
    const auto keys = FarmKeys::parse(text);
    ASSERT_FALSE(keys) << text;
    EXPECT_THAT(keys.error().detail, HasSubstr(message));
    EXPECT_THAT(keys.error().detail, Not(HasSubstr("hunter2")));
    EXPECT_THAT(keys.error().detail, Not(HasSubstr("aaaa")));
  }
  const test::TemporaryFolder folder;
  EXPECT_TRUE(FarmKeys::load(folder.write("keys", "# farm\n" + kOld + "\r\n\n")));
  EXPECT_THAT(FarmKeys::load(folder / "absent").error().detail, HasSubstr("cannot be read"));
  EXPECT_THAT(FarmKeys::load(folder.path).error().detail, HasSubstr("cannot be read: Is a directory"));
}

}  // namespace
}  // namespace fracture
