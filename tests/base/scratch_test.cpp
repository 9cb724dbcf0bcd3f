#include "common/base/scratch.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <thread>

#include "common/base/execution.hpp"
#include "common/base/stamped_map.hpp"
#include "tests/support/eventually.hpp"

namespace fracture {
namespace {

struct Buffer {
  std::vector<char> content;
  std::size_t bytes() const { return bytes_of_vectors(content); }
  void release() { release_vectors(content); }
};

TEST(Scratch, IsKeptFromUseToUseAndEachThreadHasItsOwn) {
  Buffer& mine = thread_scratch<Buffer>();
  mine.content.assign(1000, 'x');
  EXPECT_EQ(&thread_scratch<Buffer>(), &mine);
  EXPECT_GE(scratch_of_this_thread(), 1000u);
  std::thread([&] {
    EXPECT_NE(&thread_scratch<Buffer>(), &mine);
    EXPECT_EQ(scratch_of_this_thread(), 0u);
  }).join();
}

TEST(Scratch, OnlyWhatIsLargeIsGivenBack) {
  std::thread([] {
    thread_scratch<Buffer>().content.resize(1000);
    trim_scratch();
    EXPECT_GE(scratch_of_this_thread(), 1000u);
    worker_map().next_epoch(kScratchPerThread);
    EXPECT_GT(scratch_of_this_thread(), kScratchPerThread);
    trim_scratch();
    EXPECT_EQ(scratch_of_this_thread(), 0u);
    // A buffer that was given back can be used again.
    worker_map().next_epoch(10);
    EXPECT_EQ(worker_map().slot(9), StampedMap::kEmpty);
  }).join();
}

TEST(Scratch, ATrimmerTrimsAtTheEndOfItsLife) {
  std::thread([] {
    {
      const ScratchTrimmer trimmer;
      thread_scratch<Buffer>().content.resize(kScratchPerThread + 1);
    }
    EXPECT_EQ(scratch_of_this_thread(), 0u);
  }).join();
}

/// A buffer that counts itself once it has grown large.
struct Counted {
  static inline std::atomic<std::size_t> large{0};
  std::vector<char> content;
  bool counted = false;
  void grow() {
    content.resize(2 * kScratchPerThread);
    if (!std::exchange(counted, true)) ++large;
  }
  std::size_t bytes() const { return bytes_of_vectors(content); }
  void release() {
    release_vectors(content);
    if (std::exchange(counted, false)) --large;
  }
};

TEST(Scratch, HelperThreadsGiveBackWhatIsLargeWhenTheyAreIdle) {
  Execution execution;
  execution.threads = 4;
  std::mutex mutex;
  std::set<std::thread::id> threads;
  // Repeats until helper threads took part: their number is not guaranteed.
  for (int round = 0; round < 1000 && threads.size() < 2; ++round)
    parallel_for(execution, 16, 1, [&](std::size_t, std::size_t) {
      thread_scratch<Counted>().grow();
      const std::lock_guard lock(mutex);
      threads.insert(std::this_thread::get_id());
    });
  ASSERT_GE(threads.size(), 2u);
  EXPECT_GE(Counted::large.load(), 2u);
  trim_scratch();
  EXPECT_TRUE(test::eventually(test::kPatience, "the threads to let go", [] { return Counted::large == 0; }));
}

}  // namespace
}  // namespace fracture
