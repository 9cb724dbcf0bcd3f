// The order of calls for the disk: the writes of one client do not delay another client.
#include "server/jobs/disk_work.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <latch>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

TEST(DiskWork, WhatOneClientWritesHoldsUpNobodyElse) {
  std::latch gate(1);
  DiskWork disk;
  std::atomic<int> own{0}, other{0};
  disk.run("a", [&] { gate.wait(); });
  for (int k = 0; k < 100; ++k) disk.run("a", [&] { ++own; });
  for (int k = 0; k < 10; ++k) disk.run("b", [&] { ++other; });
  EXPECT_TRUE(eventually(kPatience, "the other's calls", [&] { return other == 10; }));
  EXPECT_EQ(own, 0) << "one after the other";
  gate.count_down();
  disk.flush();
  EXPECT_EQ(own, 100);
}

TEST(DiskWork, CallsOfAClientAreMadeInTheirOrderAndOneAtATime) {
  std::vector<int> order[3];
  std::atomic<int> at_once[3] = {0, 0, 0}, most = 0;
  {
    DiskWork disk;
    for (int k = 0; k < 300; ++k)
      disk.run(std::to_string(k % 3), [&, k] {
        most = std::max<int>(most, ++at_once[k % 3]);
        order[k % 3].push_back(k);
        --at_once[k % 3];
      });
  }  // The destructor makes all remaining calls.
  EXPECT_EQ(most, 1);
  for (int client = 0; client < 3; ++client) {
    EXPECT_EQ(order[client].size(), 100u);
    EXPECT_TRUE(std::is_sorted(order[client].begin(), order[client].end()));
  }
}

TEST(DiskWork, AFlushWaitsForWhatWasAskedBefore) {
  DiskWork disk;
  disk.flush();
  std::atomic<int> done{0};
  for (int k = 0; k < 50; ++k) disk.run(std::to_string(k), [&] { ++done; });
  disk.flush();
  EXPECT_EQ(done, 50);
}

TEST(DiskWork, WhoHasMoreClientsThanThereAreThreadsWaitsForOneOfThem) {
  std::latch gate(1);
  DiskWork disk;
  std::atomic<std::size_t> begun{0}, done{0};
  for (std::size_t k = 0; k < 2 * DiskWork::kMostThreads; ++k)
    disk.run(std::to_string(k), [&] {
      ++begun;
      gate.wait();
      ++done;
    });
  EXPECT_TRUE(eventually(kPatience, "all threads", [&] { return begun == DiskWork::kMostThreads; }));
  gate.count_down();
  disk.flush();
  EXPECT_EQ(done, 2 * DiskWork::kMostThreads);
}

TEST(DiskWork, AfterACallThatThrowsTheNextOneIsMade) {
  DiskWork disk;
  std::atomic<int> done{0};
  disk.run("a", [] { throw std::runtime_error("the disk is full"); });
  disk.run("a", [&] { ++done; });
  disk.flush();
  EXPECT_EQ(done, 1);
}

}  // namespace
}  // namespace fracture::test
