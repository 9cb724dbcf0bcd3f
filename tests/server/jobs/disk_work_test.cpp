// The order of calls for the disk: the writes of one client do not delay another client. Tests count the calls of
// others that come first.
#include "server/jobs/disk_work.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <latch>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/support/jobs_host.hpp"
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

/// Eight clients use all threads, and each has ten more calls in line.
TEST(DiskWork, WhoHasNotUsedTheDiskIsNextWhenAThreadIsFree) {
  std::latch first(1), second(1);
  std::atomic<std::size_t> begun{0}, later{0}, before{1000};
  DiskWork disk;
  for (std::size_t k = 0; k < DiskWork::kMostThreads; ++k) {
    disk.run(std::to_string(k), [&] {
      ++begun;
      first.wait();
    });
    for (int call = 0; call < 10; ++call)
      disk.run(std::to_string(k), [&] {
        ++later;
        second.wait();
      });
  }
  EXPECT_TRUE(eventually(kPatience, "all threads", [&] { return begun == DiskWork::kMostThreads; }));
  disk.run("other", [&] { before = later.load(); });
  first.count_down();
  EXPECT_TRUE(eventually(kPatience, "the other's call", [&] { return before != 1000; }));
  EXPECT_LT(before, DiskWork::kMostThreads) << "calls that the other threads began at the same time";
  second.count_down();
  disk.flush();
  EXPECT_EQ(later, 10 * DiskWork::kMostThreads);
}

/// The jobs of one client wait for a write of that client. The jobs of another one are accepted meanwhile.
TEST(DiskOfJobs, AFloodOfOneClientIsBehindTheJobsOfAnother) {
  const TemporaryFolder folder;
  std::atomic<int> flood{0}, other{0};
  Gate gate;
  JobsHost host(folder.path);
  const auto start = [&](const std::string& client, std::uint64_t seed, std::function<void()> accepted) {
    Terms terms;
    terms.priority = Priority::kBackground;
    terms.deadline = far_off();
    terms.payer.flow = {client, 1};
    EXPECT_FALSE(host.jobs.start(fracture_request("mesh of " + client, seed), terms, {},
                                 [accepted = std::move(accepted)](const JobView&) { accepted(); }));
  };
  start("flood", 1, [&] {
    ++flood;
    gate.pass_without_polls();
  });
  gate.wait_for(1);
  for (std::uint64_t seed = 2; seed <= 20; ++seed) start("flood", seed, [&] { ++flood; });
  for (std::uint64_t seed = 1; seed <= 5; ++seed) start("other", seed, [&] { ++other; });
  EXPECT_TRUE(eventually(kPatience, "the other's jobs", [&] { return other == 5; }));
  EXPECT_EQ(flood, 1) << "19 jobs of the flood came before them";
  gate.open = true;
  host.idle();
  EXPECT_EQ(flood, 20);
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
