#include "common/base/allocator.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

#include <map>

namespace fracture {
namespace {

// In a program of its own: the setting is the process's.
TEST(Allocator, SmallBlocksAreNotPutAside) {
#if defined(FRACTURE_SANITIZED)
  GTEST_SKIP() << "another allocator";
#endif
  join_small_blocks_when_freed();
  {
    std::map<int, int> nodes;
    for (int k = 0; k < 200'000; ++k) nodes[k] = k;
  }
  EXPECT_EQ(::mallinfo2().fsmblks, 0u) << "bytes that the next large block would have to work off";
}

}  // namespace
}  // namespace fracture
