// How often an import polls before its worker begins to read.
#include <gtest/gtest.h>

#include <cstddef>
#include <stop_token>
#include <string>

#include "common/base/turn.hpp"
#include "tests/server/support/import_pool_fixture.hpp"

namespace fracture::test {
namespace {

/// The turn of a computation, which counts what the import passes on to it.
struct TurnThatCountsPolls final : Turn {
  void give_way() override { ++polls; }
  void leave() override {}
  void come_back() override {}
  int polls = 0;
};

// Two searches for pictures and the copy for the worker, each with a poll for each quarter of a mebibyte.
TEST(ImportPolls, AFileOfMagicBytesIsSearchedAndCopiedInPieces) {
  ImportPool pool(config_of(FRACTURE_IMPORT_PROGRAM, 1));
  constexpr int kMiB = 32;
  std::string file = kTetrahedron + "#";
  file.append(static_cast<std::size_t>(kMiB) << 20, '\x89');
  file += "\n";
  TurnThatCountsPolls turn;
  Execution execution;
  execution.turn = &turn;
  (void)import_with(pool, file, execution);
  EXPECT_GE(turn.polls, 3 * 4 * kMiB);
}

/// The computation is cancelled while its file is copied. The worker never reads it, and a fresh one takes its place.
TEST(ImportPolls, AnImportIsGivenUpWhileItsFileIsCopied) {
  ImportPool pool(config_of(FRACTURE_IMPORT_PROGRAM, 1));
  constexpr int kMiB = 8;
  const std::string file(static_cast<std::size_t>(kMiB) << 20, '\x89');
  std::stop_source stop;
  bool reads = false;
  int polls = 0;
  Execution execution;
  execution.stop = stop.get_token();
  execution.watch = [&] {
    reads = reads || pool.counters().busy == 1;
    if (reads && ++polls == 8) stop.request_stop();
  };
  EXPECT_THROW((void)import_with(pool, file, execution), Interrupted);
  EXPECT_EQ(polls, 8);
  EXPECT_EQ(pool.counters().interrupted, 1u);
  EXPECT_EQ(pool.counters().busy, 0);
  EXPECT_TRUE(import_with(pool, kTetrahedron)) << "others go on";
}

}  // namespace
}  // namespace fracture::test
