// How much memory the answers in transit may hold, for each client and in total.
#include "server/http/held_buffers.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <memory>
#include <optional>
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

// -- answers that are larger than their client's part

struct LargeAnswersOnTheirWay : AnswersOnTheirWay {
  std::uint64_t aside = 0, room = 1'000'000;  ///< memory elsewhere: taken, and available
  HeldBuffers memory{1000, 250,
                     [this](const std::string&, std::uint64_t bytes,
                            std::shared_ptr<const void>& taken) -> std::optional<Refusal> {
                       if (aside + bytes > room) return Refusal::kFull;
                       aside += bytes;
                       taken =
                           std::shared_ptr<const void>(this, [this, bytes](const void*) { aside -= bytes; });
                       return std::nullopt;
                     }};
};

TEST_F(LargeAnswersOnTheirWay, AreSetAsideBeyondTheirPartUntilTheyAreRead) {
  HeldBuffers::Hold large, small, second, again;
  const void* const first = buffer();
  EXPECT_FALSE(memory.take("a", first, 5000, large));
  EXPECT_EQ(memory.used(), 250u) << "the share of a lone client";
  EXPECT_EQ(aside, 4750u);
  EXPECT_FALSE(memory.take("b", buffer(), 10, small)) << "others find room";
  EXPECT_EQ(memory.take("a", buffer(), 10, second), Refusal::kOverShare);
  EXPECT_FALSE(memory.take("a", first, 5000, again)) << "it is counted already";
  large = {};
  EXPECT_EQ(aside, 4750u) << "it is still being sent";
  again = {};
  EXPECT_EQ(aside, 0u);
  EXPECT_EQ(memory.used(), 10u);
}

TEST_F(LargeAnswersOnTheirWay, AreRefusedIfNothingCanBeSetAside) {
  room = 4000;
  HeldBuffers::Hold hold;
  EXPECT_EQ(memory.take("a", buffer(), 5000, hold), Refusal::kFull);
  EXPECT_EQ(memory.used(), 0u);
  EXPECT_FALSE(memory.take("a", buffer(), 250, hold));
  EXPECT_EQ(aside, 0u);
}

// The first client's part is 1 * 3 / (2 + 1) = 1 byte, and the next one's is 1 * 2 / (2 + 2) < 1, so none.
TEST_F(LargeAnswersOnTheirWay, AreTheirClientsOnlyOneAlsoIfAllOfThemIsSetAside) {
  HeldBuffers tiny(
      3, 1, [](const std::string&, std::uint64_t, std::shared_ptr<const void>&) -> std::optional<Refusal> {
        return std::nullopt;
      });
  HeldBuffers::Hold first, second, further;
  EXPECT_FALSE(tiny.take("a", buffer(), 1, first));
  EXPECT_FALSE(tiny.take("b", buffer(), 1, second));
  EXPECT_EQ(tiny.used(), 1u) << "nothing of b's";
  EXPECT_EQ(tiny.take("b", buffer(), 1, further), Refusal::kOverShare);
}

TEST_F(LargeAnswersOnTheirWay, StayCountedForTheLastClientThatReadsTheSameOne) {
  room = 4750;
  const void* const shared = buffer();
  HeldBuffers::Hold first, second;
  EXPECT_FALSE(memory.take("a", shared, 5000, first));
  EXPECT_FALSE(memory.take("b", shared, 5000, second)) << "it takes no further memory";
  EXPECT_EQ(memory.used() + aside, 5000u);
  first = {};
  EXPECT_EQ(memory.used() + aside, 5000u);
  second = {};
  EXPECT_EQ(memory.used() + aside, 0u);
}

}  // namespace
}  // namespace fracture::http
