// Entries of the disk cache that are not evicted.
#include <gtest/gtest.h>

#include "tests/server/support/disk_entries.hpp"

namespace fracture::test {
namespace {

struct Pins : Disk {};

TEST_F(Pins, APinnedEntryStaysWhateverElseIsWritten) {
  DiskCache cache(path, 3500);  // three entries
  insert(cache, 0);
  EXPECT_TRUE(cache.pin(key_of(0)));
  EXPECT_FALSE(cache.pin(key_of(1))) << "not written yet";
  for (int n = 1; n < 10; ++n) EXPECT_TRUE(insert(cache, n)) << n;
  EXPECT_TRUE(finds(cache, 0));
  EXPECT_TRUE(finds(cache, 1));
  EXPECT_FALSE(finds(cache, 8));
  EXPECT_FALSE(insert(cache, 10, 2000)) << "the pinned ones leave no room for it";
  EXPECT_TRUE(finds(cache, 9)) << "and nothing was evicted for it";
  EXPECT_LE(cache.figures().bytes, 3500u);
  cache.unpin(key_of(0));
  EXPECT_TRUE(cache.pin(key_of(1)));  // of two jobs
  cache.unpin(key_of(1));
  cache.unpin(key_of(7));  // not pinned
  for (int n = 11; n < 14; ++n) EXPECT_TRUE(insert(cache, n)) << n;
  EXPECT_FALSE(finds(cache, 0));
  EXPECT_TRUE(finds(cache, 1));
  cache.refuse(key_of(1));
  EXPECT_TRUE(insert(cache, 1)) << "its pin stays without it";
  for (int n = 14; n < 18; ++n) EXPECT_TRUE(insert(cache, n)) << n;
  EXPECT_TRUE(finds(cache, 1));
}

/// A smaller budget than that of the earlier process, or other requests, must not evict what will be pinned.
TEST_F(Pins, NothingIsEvictedBeforeThePinsAreKnown) {
  {
    DiskCache cache(path, 1 << 20);
    for (int n = 0; n < 10; ++n) insert(cache, n);
  }
  DiskCache cache(path, 3500);
  cache.keep_all(true);
  EXPECT_FALSE(insert(cache, 10));
  EXPECT_EQ(entries_in(path).size(), 10u);
  EXPECT_TRUE(cache.pin(key_of(0)));
  cache.keep_all(false);
  EXPECT_TRUE(insert(cache, 10));
  EXPECT_TRUE(finds(cache, 0));
  EXPECT_LE(cache.figures().bytes, 3500u);
  EXPECT_EQ(entries_in(path).size(), 3u);
}

}  // namespace
}  // namespace fracture::test
