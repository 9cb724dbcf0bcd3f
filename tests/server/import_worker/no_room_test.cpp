// If this machine lacks memory, descriptors or processes, the file is not to blame: the error is kOverloaded,
// which invites a retry, and it is not remembered.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <string>

#include "tests/server/support/import_pool_fixture.hpp"
#include "tests/server/support/temporary_folder.hpp"

namespace fracture::test {
namespace {

using ::testing::HasSubstr;

#ifndef FRACTURE_SANITIZED
/// Limits of this process, which the processes of a pool inherit.
class Limited {
 public:
  Limited(__rlimit_resource resource, rlim_t soft) : resource_(resource) {
    ::getrlimit(resource_, &before_);
    const rlimit less{std::min(soft, before_.rlim_max), before_.rlim_max};
    EXPECT_EQ(::setrlimit(resource_, &less), 0);
  }
  ~Limited() { ::setrlimit(resource_, &before_); }
  Limited(const Limited&) = delete;
  Limited& operator=(const Limited&) = delete;

 private:
  __rlimit_resource resource_;
  rlimit before_{};
};

/// The value of a line in /proc/self/status, in bytes.
std::uint64_t status_of(const std::string& name, pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(name)) return std::stoull(line.substr(name.size())) << 10;
  return 0;
}

/// The machine lacks memory; the file is not to blame. The limit of data is separate from the limit of the
/// address space, as with strict memory accounting (vm.overcommit_memory=2).
TEST(NoRoom, LackOfMemoryOfTheMachineIsNoFaultOfTheFileAndIsNotRemembered) {
  std::uint64_t data = 0;
  {
    ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
    // This process needs memory as well, to start the workers.
    data = std::max(status_of("VmData:", pool.pids().front()), status_of("VmData:", ::getpid()));
  }
  ASSERT_GT(data, 0u);
  ImportPoolConfig config = config_of(FRACTURE_MISBEHAVING_PROGRAM, 1);
  std::optional<Limited> limited(std::in_place, RLIMIT_DATA, data + (40u << 20));
  ImportPool pool(config);
  limited.reset();
  for (int k = 0; k < 2; ++k) {
    const Expected<Mesh> refused = import_with(pool, "! memory");
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kOverloaded) << refused.error().detail;
    EXPECT_GT(refused.error().retry_after.count(), 0);
    EXPECT_THAT(refused.error().detail, HasSubstr("the system refused memory"));
  }
  EXPECT_EQ(pool.counters().no_room, 2u);
  EXPECT_EQ(pool.counters().remembered, 0u);
  EXPECT_EQ(pool.counters().crashed, 0u);
  EXPECT_TRUE(import_with(pool, kTetrahedron)) << "what fits is read";
}

TEST(NoRoom, LessThanAnImportMayHaveIsLackOfRoomToo) {
  std::uint64_t space = 0;
  {
    ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
    space = pool.zygote_hello().address_space;
  }
  // As if the server had been started under `ulimit -v`, but without limiting the server itself.
  const TemporaryFolder folder;
  const std::string program = folder / "limited";
  std::ofstream(program) << "#!/bin/sh\nulimit -v " << (space >> 10) + (64u << 10) << "\nexec '"
                         << FRACTURE_MISBEHAVING_PROGRAM << "' \"$@\"\n";
  fs::permissions(program, fs::perms::owner_all);
  ImportPool pool(config_of(program.c_str(), 1));
  for (int k = 0; k < 2; ++k) {
    const Expected<Mesh> refused = import_with(pool, "! memory");
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kOverloaded) << refused.error().detail;
  }
  EXPECT_EQ(pool.counters().remembered, 0u);
  EXPECT_TRUE(import_with(pool, kTetrahedron));
}

/// The memory of the program and its libraries is not charged to the file.
TEST(NoRoom, AMebibyteIsEnoughForASmallFile) {
  ImportPoolConfig config = config_of(FRACTURE_IMPORT_PROGRAM, 1);
  config.worker.memory_bytes = 1u << 20;
  ImportPool pool(config);
  EXPECT_TRUE(import_with(pool, kTetrahedron));
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  const Expected<Mesh> read = pool.import(bytes_of(obj), MeshFormat::kObj, {}, {}, {}, digest_of(obj));
  EXPECT_TRUE(read) << read.error().detail;
}
#endif

TEST(NoRoom, WithoutReadersThereIsNoRoom) {
#ifdef FRACTURE_SANITIZED
  GTEST_SKIP() << "the sanitizer needs descriptors of its own to look at an exception";
#endif
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  ASSERT_TRUE(settles(pool));
  // No further descriptor is available, so there is no shared memory for a file.
  const rlimit none{3, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  std::optional<Expected<Mesh>> result;
  std::optional<Error> thrown;
  try {
    result = import_with(pool, kTetrahedron);
  } catch (const Interrupted& interrupted) {
    if (interrupted.error) thrown = *interrupted.error;
  }
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  if (result && !*result) thrown = result->error();
  ASSERT_TRUE(thrown);
  EXPECT_EQ(thrown->code, ErrorCode::kOverloaded) << thrown->detail;
  EXPECT_GE(pool.counters().no_room, 1u);
  EXPECT_TRUE(eventually(kPatience, "the file to be read", [&] {
    try {
      return import_with(pool, kTetrahedron).has_value();
    } catch (const Interrupted&) {  // no reader could be started
      return false;
    }
  })) << "it is not remembered";
  EXPECT_EQ(pool.counters().remembered, 0u);
}

}  // namespace
}  // namespace fracture::test
