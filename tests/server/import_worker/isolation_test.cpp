// How files are isolated from each other: one process for each file, a memory of files that killed their
// process, and the sandbox.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <seccomp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <future>

#include "tests/server/support/import_pool_fixture.hpp"

namespace fracture::test {
namespace {

using ::testing::HasSubstr;

/// Prevents this process and its children from loading further filters.
void deny_seccomp() {
  const auto filter = seccomp_init(SCMP_ACT_ALLOW);
  const auto refused = SCMP_ACT_ERRNO(EPERM);
  const bool done =
      seccomp_rule_add(filter, refused, SCMP_SYS(seccomp), 0) == 0 &&
      seccomp_rule_add(filter, refused, SCMP_SYS(prctl), 1, SCMP_A0(SCMP_CMP_EQ, PR_SET_SECCOMP, 0)) == 0 &&
      seccomp_load(filter) == 0;
  seccomp_release(filter);
  if (!done) std::fputs("no filter can be loaded here at all", stderr);
}

TEST(ImportIsolation, NoFileFindsWhatAnotherLeftInItsReader) {
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
  for (int k = 0; k < 3; ++k) {
    const pid_t reader = pool.pids().at(0);
    EXPECT_TRUE(import_with(pool, "! stay"));
    const Expected<Mesh> next = import_with(pool, "! look " + std::to_string(k));
    ASSERT_FALSE(next);
    EXPECT_EQ(next.error().detail, "nobody was here");
    ASSERT_TRUE(settles(pool));
    EXPECT_NE(pool.pids().at(0), reader);
  }
  EXPECT_EQ(pool.counters().zygotes, 1u) << "forks, not starts";
  EXPECT_GE(pool.counters().started, 6u);
}

TEST(ImportIsolation, TheZygoteHasOneThreadAndReadsNoFile) {
  ImportPool pool(config_of(FRACTURE_IMPORT_PROGRAM, 1));
  const std::string proc = "/proc/" + std::to_string(pool.zygote_pid());
  EXPECT_EQ(std::distance(fs::directory_iterator(proc + "/task"), {}), 1);
  EXPECT_TRUE(import_with(pool, kTetrahedron));
  // Its only connection carries nothing but requests to fork: the file went to the worker.
  ASSERT_TRUE(settles(pool));
  EXPECT_NE(pool.pids().at(0), pool.zygote_pid());
  EXPECT_EQ(pool.counters().zygotes, 1u);
}

TEST(ImportIsolation, AZygoteThatIsKilledIsReplaced) {
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
  const pid_t first = pool.zygote_pid();
  ASSERT_EQ(::kill(first, SIGKILL), 0);
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(import_with(pool, kTetrahedron));
  ASSERT_TRUE(settles(pool));
  EXPECT_NE(pool.zygote_pid(), first);
  EXPECT_EQ(pool.counters().zygotes, 2u);
}

TEST(ImportIsolation, AForkOfWhichNobodyWasToldIsNoProcessForEver) {
  WorkerProcessConfig config;
  config.program = FRACTURE_FORGETFUL_PROGRAM;
  const std::size_t before = children();
  {
    ZygoteProcess zygote(config);
    EXPECT_THROW(zygote.fork(), std::runtime_error);
    EXPECT_GT(children(), before) << "the fork of a zygote is a child of the server";
  }
  EXPECT_EQ(children(), before);
}

TEST(ImportIsolation, TheLayoutOfMemoryIsANewOneAfterACrashAndAfterManyForks) {
  ImportPoolConfig config = config_of(FRACTURE_MISBEHAVING_PROGRAM, 1);
  config.max_forks = 5;
  ImportPool pool(config);
  for (int k = 0; k < 12; ++k) EXPECT_TRUE(import_with(pool, kTetrahedron));
  ASSERT_TRUE(settles(pool));
  EXPECT_EQ(pool.counters().started, 13u);
  EXPECT_EQ(pool.counters().zygotes, 3u);
  EXPECT_FALSE(import_with(pool, "! exit"));
  ASSERT_TRUE(settles(pool));
  EXPECT_EQ(pool.counters().zygotes, 4u);
}

TEST(ImportIsolation, AFileThatKilledItsReaderIsRefusedAtOnceWithTheSameError) {
  ImportPoolConfig config = config_of(FRACTURE_MISBEHAVING_PROGRAM, 1);
  config.worker.cpu = 1s;
  ImportPool pool(config);
  for (const char* command : {"! null", "! exit", "! lie", "! spin", "! unfold"}) {
    const Expected<Mesh> first = import_with(pool, command);
    ASSERT_TRUE(settles(pool));
    const ImportCounters before = pool.counters();
    const Expected<Mesh> again = import_with(pool, command);
    ASSERT_FALSE(first) << command;
    ASSERT_FALSE(again) << command;
    EXPECT_EQ(again.error().code, first.error().code) << command;
    EXPECT_EQ(again.error().detail, first.error().detail) << command;
    EXPECT_EQ(*again.error().extra, *first.error().extra) << command;
    EXPECT_EQ(pool.counters().remembered, before.remembered + 1) << command;
    EXPECT_EQ(pool.counters().started, before.started) << command << ": without a process";
  }
  // The same bytes in another format are a different input. A refusal by a reader is not remembered.
  EXPECT_FALSE(pool.import(bytes_of("! exit"), MeshFormat::kObj, {}, {}, {}, digest_of("! exit")));
  const std::uint64_t remembered = pool.counters().remembered;
  for (int k = 0; k < 2; ++k) EXPECT_FALSE(import_with(pool, "! try open"));
  EXPECT_EQ(pool.counters().remembered, remembered);
  EXPECT_TRUE(import_with(pool, kTetrahedron));
}

TEST(ImportIsolation, AWorkerThatSomebodyElseKilledSaysNothingAboutItsFile) {
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
  for (int k = 0; k < 2; ++k) {
    ASSERT_TRUE(settles(pool));
    auto doomed = std::async(std::launch::async, [&] { return import_with(pool, "! hang"); });
    const pid_t first = next_reader(pool, -1);
    ASSERT_EQ(::kill(first, SIGKILL), 0);
    ASSERT_EQ(::kill(next_reader(pool, first), SIGKILL), 0);
    EXPECT_FALSE(doomed.get());
  }
  EXPECT_EQ(pool.counters().no_room, 2u) << "tried both times";
  EXPECT_EQ(pool.counters().crashed, 0u);
  EXPECT_EQ(pool.counters().remembered, 0u);
}

TEST(ImportIsolation, AFileThatRanOutOfTimeIsNotTriedWithAsLittleAgain) {
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
  const auto within = [&](std::chrono::milliseconds time) {
    Execution execution;
    execution.deadline = std::chrono::steady_clock::now() + time;
    try {
      (void)import_with(pool, "! spin", execution);
      ADD_FAILURE() << "it should have been interrupted";
    } catch (const Interrupted& interrupted) {
      EXPECT_EQ(interrupted.code, ErrorCode::kDeadlineExceeded);
    }
    return pool.counters();
  };
  // Only processor time is remembered. On a busy machine, an import needs longer to use as much as the second attempt would have.
  std::chrono::milliseconds time = 1500ms;
  ImportCounters before = within(time);
  EXPECT_EQ(before.interrupted, 1u);
  ImportCounters less;
  do {
    ASSERT_TRUE(settles(pool));
    before = pool.counters();
    less = within(100ms);
    if (less.remembered > 0) break;
    (void)within(time *= 2);
  } while (time < 20s);
  EXPECT_EQ(less.remembered, 1u) << "less time: refused at once";
  EXPECT_EQ(less.started, before.started);
  EXPECT_EQ(less.interrupted, before.interrupted);
  EXPECT_EQ(within(2 * time).interrupted, before.interrupted + 1) << "more time: tried";
}

TEST(ImportMemo, IsBoundedAndForgets) {
  ImportMemo memo;
  const ImportMemo::Clock::time_point now{};
  const Error error{ErrorCode::kImporterCrashed, "it died", {}, {}};
  for (std::size_t k = 0; k < ImportMemo::kMost + 10; ++k)
    memo.add(std::to_string(k), error, ImportMemo::kAnyMemory, now);
  EXPECT_FALSE(memo.find("9", now));
  ASSERT_TRUE(memo.find("10", now));
  EXPECT_EQ(memo.find("10", now)->error->detail, "it died");
  EXPECT_FALSE(memo.find("10", now + ImportMemo::kTimeToLive)) << "a moment's trouble passes";
  memo.add("10", 5s, now + ImportMemo::kTimeToLive);
  memo.add("10", 3s, now + ImportMemo::kTimeToLive);
  const auto known = memo.find("10", now + ImportMemo::kTimeToLive);
  ASSERT_TRUE(known);
  EXPECT_FALSE(known->error) << "begun anew";
  EXPECT_EQ(known->needs_more_than, 5s);
}

TEST(ImportIsolation, AnAnswerToAnotherFileIsNone) {
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
  const Expected<Mesh> answered = import_with(pool, "! answer for another");
  ASSERT_FALSE(answered);
  EXPECT_EQ(answered.error().code, ErrorCode::kImporterCrashed);
  EXPECT_THAT(answered.error().detail, HasSubstr("an answer to another file"));
  EXPECT_TRUE(import_with(pool, kTetrahedron));
}

TEST(ImportIsolation, WhereTheSandboxIsRequiredAndCannotBeHadNothingStarts) {
  ImportPoolConfig config = config_of(FRACTURE_IMPORT_PROGRAM, 1);
  config.worker.require_sandbox = true;
  { ImportPool pool(config); }
  // As in a container whose own filter allows no further filters. This affects a whole process.
  EXPECT_EXIT(
      {
        deny_seccomp();
        try {
          ImportPool pool(config);
          std::fputs("it started", stderr);
        } catch (const std::exception& e) {
          std::fputs(e.what(), stderr);
        }
        config.worker.require_sandbox = false;
        ImportPool pool(config);
        std::fprintf(stderr, "; else: seccomp %u", pool.hello().seccomp);
        ::_exit(import_with(pool, kTetrahedron) ? 0 : 1);
      },
      testing::ExitedWithCode(0), "sandbox of the import workers is required.*; else: seccomp 0");
}

}  // namespace
}  // namespace fracture::test
