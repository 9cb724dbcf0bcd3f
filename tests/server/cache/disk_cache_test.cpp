#include "server/cache/disk_cache.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

#include "tests/server/support/disk_entries.hpp"
#include "tests/server/support/odd_files.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/support/polls.hpp"

namespace fracture {
namespace {

namespace fs = std::filesystem;
using test::entries_in;
using test::kAllOdd;
using test::key_of;
using test::Odd;
using test::payload_of;
using test::put_odd;
using Bytes = std::vector<std::uint8_t>;

struct Disk : test::Disk {};

Bytes encode(const CacheEntry& entry) {
  const std::string head = encode_entry_head(entry);
  Bytes bytes(head.begin(), head.end());
  bytes.insert(bytes.end(), entry.payload.begin(), entry.payload.end());
  return bytes;
}

// -- the entry

TEST(CacheEntry, WhatIsEncodedIsDecoded) {
  for (const std::size_t size : {0u, 1u, 1000u}) {
    const Bytes payload = payload_of(1, size);
    const Bytes bytes = encode({"abcd", "some\nmetadata", payload});
    const auto entry = decode_entry(bytes, "abcd");
    ASSERT_TRUE(entry);
    EXPECT_EQ(entry->key, "abcd");
    EXPECT_EQ(entry->metadata, "some\nmetadata");
    EXPECT_TRUE(std::equal(payload.begin(), payload.end(), entry->payload.begin(), entry->payload.end()));
    EXPECT_FALSE(decode_entry(bytes, "abce")) << "another key";
  }
}

TEST(CacheEntry, EveryTruncationEveryExtensionAndEveryFlippedBitIsSeen) {
  const Bytes payload = payload_of(1, 100), bytes = encode({"abcd", "m", payload});
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(decode_entry(std::span(bytes).first(size), "abcd")) << size;
  Bytes longer = bytes;
  longer.push_back(0);
  EXPECT_FALSE(decode_entry(longer, "abcd"));
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    Bytes flipped = bytes;
    flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ (1u << (bit % 8)));
    EXPECT_FALSE(decode_entry(flipped, "abcd")) << bit;
  }
}

TEST(CacheEntry, SizesThatOverflowAreRefused) {
  const Bytes payload = payload_of(1, 10), bytes = encode({"abcd", "m", payload});
  for (std::size_t at = 8; at < 24; ++at)
    for (const std::uint8_t value : {0x7f, 0x80, 0xff}) {
      Bytes damaged = bytes;
      damaged[at] = value;
      EXPECT_FALSE(decode_entry(damaged, "abcd")) << at;
    }
}

// -- the folder

TEST_F(Disk, WhatIsWrittenIsFoundAlsoByTheNextProcess) {
  {
    DiskCache cache(path, 1 << 20);
    EXPECT_FALSE(cache.unusable());
    EXPECT_FALSE(finds(cache, 1));
    EXPECT_TRUE(insert(cache, 1));
    EXPECT_TRUE(finds(cache, 1));
  }
  DiskCache next(path, 1 << 20);
  EXPECT_TRUE(finds(next, 1));
  EXPECT_EQ(next.figures().entries, 1u);
  EXPECT_EQ(next.figures().bytes, fs::file_size(entries_in(path).at(0)));
}

// The file is read, its signature is computed, and its checksum, each with a poll for each quarter of a mebibyte.
TEST_F(Disk, ReadingALargeEntryPolls) {
  constexpr std::size_t kSize = std::size_t{8} << 20;
  DiskCache cache(path, 100u << 20, *FarmKeys::parse(std::string(64, 'k')), 1);
  ASSERT_TRUE(insert(cache, 1, kSize));
  test::Polls polls;
  const auto stored = cache.find(key_of(1), polls.execution);
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->entry.payload.size(), kSize);
  EXPECT_GE(polls.count, 3 * 32);

  test::Polls stopped(polls.count);
  EXPECT_THROW(cache.find(key_of(1), stopped.execution), Interrupted);
  EXPECT_TRUE(finds(cache, 1)) << "an interruption says nothing about the entry";
}

TEST_F(Disk, TheLeastRecentlyUsedLeavesWhenTheBudgetIsReached) {
  DiskCache cache(path, 3500);
  for (int n = 0; n < 3; ++n) insert(cache, n);
  EXPECT_TRUE(finds(cache, 0));
  EXPECT_TRUE(insert(cache, 3));
  EXPECT_TRUE(finds(cache, 0));
  EXPECT_FALSE(finds(cache, 1));
  EXPECT_FALSE(insert(cache, 4, 5000)) << "over the budget alone";
  EXPECT_EQ(entries_in(path).size(), 3u);
  EXPECT_LE(cache.figures().bytes, 3500u);
}

TEST_F(Disk, WhatIsNotAFileIsNeverReadAndItsNeighboursStay) {
  const auto place = [this](int n) { return path + "/" + key_of(n).substr(0, 2) + "/" + key_of(n); };
  {
    DiskCache cache(path, 1 << 20);
    for (int n = 0; n < 10; ++n) insert(cache, n);
  }
  int odd_one = 100;
  for (const Odd odd : kAllOdd) {
    put_odd(odd, place(odd_one));
    put_odd(odd, path + "/z" + std::to_string(odd_one % 10));  // where a folder of entries may be
    ++odd_one;
  }
  DiskCache cache(path, 1 << 20);
  ASSERT_FALSE(cache.unusable());
  for (int n = 0; n < 10; ++n) EXPECT_TRUE(finds(cache, n)) << n;
  for (int n = 100; n < odd_one; ++n) EXPECT_FALSE(finds(cache, n)) << n;
  EXPECT_EQ(cache.figures().quarantined, 1u) << "the one that is larger than all of the cache";
  int changed = 0;
  for (const Odd odd : kAllOdd) {
    put_odd(odd, place(changed));
    EXPECT_FALSE(finds(cache, changed)) << changed;
    EXPECT_TRUE(insert(cache, changed)) << changed;
    EXPECT_TRUE(finds(cache, changed)) << changed;
    ++changed;
  }
  EXPECT_EQ(cache.figures().quarantined, 6u);
  for (int n = 0; n < 10; ++n) EXPECT_TRUE(finds(cache, n)) << n;
}

TEST_F(Disk, ADamagedEntryIsQuarantinedAndNeverServed) {
  DiskCache cache(path, 1 << 20);
  for (int n = 0; n < 40; ++n) {
    insert(cache, n);
    const fs::path file = path + "/" + key_of(n).substr(0, 2) + "/" + key_of(n);
    if (n % 2) {
      fs::resize_file(file, static_cast<std::uintmax_t>(n) * 20);
    } else {
      std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
      stream.seekp(n * 20);
      const int old = stream.peek();
      stream.put(static_cast<char>(old ^ 4));
    }
    EXPECT_FALSE(finds(cache, n)) << n;
    EXPECT_FALSE(fs::exists(file)) << n;
  }
  EXPECT_EQ(cache.figures().quarantined, 40u);
  const auto kept = fs::directory_iterator(path + "/quarantine");
  EXPECT_LE(std::distance(begin(kept), end(kept)), 16);
  EXPECT_TRUE(insert(cache, 0));
  EXPECT_TRUE(finds(cache, 0));
}

TEST_F(Disk, TwoServersDoNotShareAFolderAndTheSecondGetsItAfterTheFirst) {
  auto first = std::make_unique<DiskCache>(path, 1 << 20);
  DiskCache second(path, 1 << 20);
  EXPECT_FALSE(second.unusable());
  EXPECT_FALSE(second.held());
  EXPECT_EQ(second.take(), false);
  EXPECT_FALSE(insert(second, 1));
  EXPECT_FALSE(finds(second, 1));
  EXPECT_TRUE(insert(*first, 1));
  first.reset();
  EXPECT_EQ(second.take(), true);
  EXPECT_TRUE(second.held());
  EXPECT_TRUE(finds(second, 1)) << "with what the first one left";
  EXPECT_TRUE(insert(second, 2));
  EXPECT_EQ(second.take(), true) << "it stays its own";
  EXPECT_EQ(second.figures().entries, 2u);
}

TEST_F(Disk, AnEntryThatIsRefusedIsPutAsideAndCanBeWrittenAgain) {
  DiskCache cache(path, 1 << 20);
  insert(cache, 1);
  cache.refuse(key_of(1));
  cache.refuse(key_of(2));
  EXPECT_EQ(cache.figures().quarantined, 1u);
  EXPECT_EQ(cache.figures().bytes, 0u);
  EXPECT_FALSE(finds(cache, 1));
  EXPECT_TRUE(insert(cache, 1));
  EXPECT_TRUE(finds(cache, 1));
}

TEST_F(Disk, WhereNothingCanBeWrittenEveryCallIsAMiss) {
  std::ofstream(folder.path + "/file") << "x";
  for (const std::string& bad :
       {folder.path + "/file", folder.path + "/file/below", std::string("/proc/cache")}) {
    DiskCache cache(bad, 1 << 20);
    EXPECT_TRUE(cache.unusable()) << bad;
    EXPECT_FALSE(insert(cache, 1));
    EXPECT_FALSE(finds(cache, 1));
  }
}

TEST_F(Disk, AFolderThatGoesAwayIsCountedAndDoesNoHarm) {
  DiskCache cache(path, 1 << 20);
  insert(cache, 1);
  fs::remove_all(path);
  EXPECT_FALSE(finds(cache, 1));
  EXPECT_FALSE(insert(cache, 2));
  EXPECT_EQ(cache.figures().failures, 1u)
      << "a file that is gone is a miss; one that cannot be made a failure";
}

TEST_F(Disk, KeysAreHexDigitsAndNothingElse) {
  DiskCache cache(path, 1 << 20);
  const Bytes payload = payload_of(1, 10);
  for (const char* key : {"", "ab", "../../../../etc/passwd", "ABCDEF0123", "abcd/ef01", "lock"}) {
    EXPECT_FALSE(cache.insert({key, "10", payload})) << key;
    EXPECT_FALSE(cache.find(key)) << key;
  }
}

/// Runs `work` in a child process, which may end in any way.
template <class Work>
int in_child(Work work) {
  const pid_t child = ::fork();
  if (child == 0) {
    work();
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return status;
}

TEST_F(Disk, WithKeysOnlyWhatTheFarmSignedIsFound) {
  const FarmKeys ours = *FarmKeys::parse(std::string(64, 'a')),
                 theirs = *FarmKeys::parse(std::string(64, 'b'));
  {
    DiskCache cache(path, 1 << 20, ours, 6);
    insert(cache, 1);
    EXPECT_TRUE(finds(cache, 1));
  }
  {
    DiskCache cache(path, 1 << 20, ours, 6);
    EXPECT_TRUE(finds(cache, 1)) << "after a restart";
    EXPECT_EQ(cache.figures().quarantined, 0u);
  }
  const auto refuses = [&](const FarmKeys& keys, int algorithm) {
    DiskCache cache(path, 1 << 20, keys, algorithm);
    const bool found = finds(cache, 1);
    EXPECT_EQ(cache.figures().quarantined, found ? 0u : 1u);
    return !found;
  };
  EXPECT_TRUE(refuses(ours, 7)) << "of another algorithm version";
  {
    DiskCache cache(path, 1 << 20, theirs, 6);
    insert(cache, 1);
  }
  EXPECT_TRUE(refuses(ours, 6)) << "of another farm";
  {
    DiskCache cache(path, 1 << 20);
    insert(cache, 1);
  }
  EXPECT_TRUE(refuses(ours, 6)) << "not signed";
}

TEST_F(Disk, WhenTheDiskIsFullWritesFailAndReadsGoOn) {
  {
    DiskCache cache(path, 1 << 20);
    insert(cache, 1);
  }
  const int status = in_child([&] {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{5000, 5000};  // for any file: write() fails in the middle, as on a full disk
    ::setrlimit(RLIMIT_FSIZE, &small);
    DiskCache cache(path, 1 << 20);
    if (insert(cache, 2, 100'000)) ::_exit(1);
    if (!finds(cache, 1)) ::_exit(2);
    if (finds(cache, 2)) ::_exit(3);
    if (cache.figures().failures != 1) ::_exit(4);
    if (!insert(cache, 3)) ::_exit(5);  // an entry that fits is still written
  });
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(fs::is_empty(path + "/tmp")) << "nothing half-written is left";
}

TEST_F(Disk, KilledAtAnyMomentItNeverServesAWrongByte) {
  const bool full = std::getenv("FRACTURE_TEST_FULL") != nullptr;
  const int rounds = full ? 200 : 25;
  std::uint32_t state = 4711;
  int found = 0;
  for (int round = 0; round < rounds; ++round) {
    int written[2];
    ASSERT_EQ(::pipe(written), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      DiskCache cache(path, 300'000);  // small, so it evicts all the time
      for (int n = 0;; n = (n + 1) % 64) {
        insert(cache, n, 100 + static_cast<std::size_t>(n) * 300);
        if (n == 8 && ::write(written[1], "8", 1) != 1) ::_exit(1);
        finds(cache, (n * 7) % 64);
      }
    }
    ::close(written[1]);
    // Every other round waits until there is something to lose. In the other rounds the process may be killed
    // right after its start.
    if (char byte = 0; round % 2 == 1) {
      ASSERT_EQ(::read(written[0], &byte, 1), 1);
    }
    state = state * 1664525u + 1013904223u;
    ::usleep(state >> 16 & 0x7fff);  // pause: up to 33 ms, so that the kill comes at any moment
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    ::close(written[0]);
    fs::create_directories(path);  // A child that is killed before it begins leaves no folder.
    // Then do what a disk may do: flip a bit, truncate a file.
    for (const fs::path& file : entries_in(path)) {
      state = state * 1664525u + 1013904223u;
      const std::uintmax_t size = fs::file_size(file);
      if (size == 0 || state >> 28 > 1) continue;
      if (state >> 28 == 0) {
        fs::resize_file(file, (state & 0xffff) % size);
      } else {
        std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
        stream.seekg((state & 0xffff) % size);
        const int old = stream.peek();
        stream.seekp((state & 0xffff) % size);
        stream.put(static_cast<char>(old ^ (1 << (state >> 20 & 7))));
      }
    }
    DiskCache cache(path, 300'000);
    ASSERT_FALSE(cache.unusable()) << "the lock of a dead process is none";
    for (int n = 0; n < 64; ++n) found += finds(cache, n);
    EXPECT_TRUE(fs::is_empty(path + "/tmp"));
    EXPECT_LE(cache.figures().bytes, 300'000u);
    if (HasFailure()) break;
  }
  EXPECT_GT(found, rounds) << "the loop has to find entries to say anything";
}

}  // namespace
}  // namespace fracture
