// How much memory the answers in transit may hold, for each client and in total.
#include "server/http/held_buffers.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <string>
#include <vector>

namespace fracture::http {
namespace {

using Refusal = HeldBuffers::Refusal;

struct AnswersOnTheirWay : testing::Test {
  std::deque<char> buffers;  // Only their addresses are used, as buffers.
  const void* buffer() { return &buffers.emplace_back(); }
};

TEST_F(AnswersOnTheirWay, OneThatIsAloneMayBeLargerThanAllThereIs) {
  HeldBuffers memory(1000, 250);
  HeldBuffers::Hold first, second;
  EXPECT_FALSE(memory.take("a", buffer(), 5000, first));
  EXPECT_EQ(memory.take("b", buffer(), 10, second), Refusal::kFull);
  first = {};
  EXPECT_FALSE(memory.take("b", buffer(), 10, second));
}

/// However many clients read slowly, there is room for the next client's answer.
TEST_F(AnswersOnTheirWay, WhateverManyClientsHoldTheNextOneFindsRoom) {
  HeldBuffers memory(1'000'000, 250'000);
  std::deque<HeldBuffers::Hold> holds;
  for (int client = 0; client < 250; ++client) {
    int taken = 0;
    while (!memory.take("client " + std::to_string(client), buffer(), 100, holds.emplace_back())) ++taken;
    ASSERT_GT(taken, 0) << client;
    if (client == 0) {
      EXPECT_EQ(taken, 2500) << "its share, while it is the only one";
    }
  }
  HeldBuffers::Hold one_more;
  EXPECT_FALSE(memory.take("one more", buffer(), 100, one_more));
  holds.clear();
  EXPECT_EQ(memory.used(), 100u);
}

TEST_F(AnswersOnTheirWay, ABufferThatManyAreSentFromIsHeldOnceAndAgainByTheSameClientForNothing) {
  HeldBuffers memory(1000, 250);
  const void* const shared = buffer();
  std::vector<HeldBuffers::Hold> holds(4);
  EXPECT_FALSE(memory.take("a", shared, 200, holds[0]));
  EXPECT_FALSE(memory.take("a", shared, 200, holds[1]));
  EXPECT_FALSE(memory.take("b", shared, 200, holds[2]));
  EXPECT_EQ(memory.used(), 200u);
  EXPECT_EQ(memory.take("a", buffer(), 200, holds[3]), Refusal::kOverShare);
}

}  // namespace
}  // namespace fracture::http
