// The pool and its processes: what a file can do to its worker, and how that affects others.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <stop_token>
#include <thread>

#include "common/import/import.hpp"
#include "common/import/sibling_files.hpp"
#include "server/import_worker/mesh_codec.hpp"
#include "tests/server/support/import_pool_fixture.hpp"
#include "tests/support/full_tests.hpp"
#include "tests/support/mesh_files.hpp"

namespace fracture::test {
namespace {

using ::testing::HasSubstr;

std::size_t open_descriptors() {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator("/proc/self/fd"), {}));
}

TEST(ImportPool, GivesTheSameMeshAsThisProcessBitForBit) {
  ImportPool pool(config_of(FRACTURE_IMPORT_PROGRAM));
  std::vector<MeshFile> files = test_meshes();
#ifndef FRACTURE_SANITIZED  // Assimp leaks memory on some of them, here as in the worker.
  for (const char* name : {"3DS/fels.3ds",
                           "AC/Wuson.ac",
                           "ASE/MotionCaptureROM.ase",
                           "B3D/WusonBlitz.b3d",
                           "BLEND/Suzanne_248.blend",
                           "COB/molecule.cob",
                           "Collada/duck.dae",
                           "DXF/wuson.dxf",
                           "FBX/spider.fbx",
                           "HMP/terrain.hmp",
                           "IFC/AC14-FZK-Haus.ifc",
                           "IQM/mrfixit.iqm",
                           "LWO/LWO2/sphere_with_mat_gloss_10pc.lwo",
                           "MD2/sydney.md2",
                           "MS3D/twospheres.ms3d",
                           "OBJ/spider.obj",
                           "Q3D/WusonOK.q3o",
                           "SMD/WusonSMD.smd",
                           "X/anim_test.x",
                           "XGL/Wuson.zgl",
                           "invalid/malformed.obj",
                           "RAW/WithColor.raw",
                           "BVH/01_01.bvh"})
    if (const auto file = assimp_model(name)) files.push_back(*file);
#endif
  std::size_t compared = 0;
  for (const MeshFile& file : files) {
    std::ifstream in(file.path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    const auto format = format_from_extension(fs::path(file.path).extension().string().substr(1));
    if (!format || (short_tests() && bytes.size() > 300'000)) continue;
    const std::vector<SiblingFile> siblings = read_sibling_files(file.path, bytes_of(bytes), *format);
    const std::vector<ImportFile> parts = as_import_files(siblings);
    const auto here = encode_reply(import_mesh(bytes_of(bytes), *format, {}, parts));
    const auto there =
        encode_reply(pool.import(bytes_of(bytes), *format, parts, {}, {}, digest_of(bytes, parts)));
    EXPECT_EQ(here == there, true) << file.name;
    ++compared;
  }
  if (compared == 0) GTEST_SKIP() << "there are no mesh files";
  EXPECT_EQ(pool.counters().crashed, 0u);
  EXPECT_EQ(pool.counters().imported + pool.counters().refused, compared);
}

TEST(ImportPool, AWorkerKilledInMidImportCostsItsRequestOnly) {
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM));
  for (const int signal : {SIGKILL, SIGSEGV}) {
    const std::vector<pid_t> before = pool.pids();
    auto doomed = std::async(std::launch::async, [&] { return import_with(pool, "! hang"); });
    ASSERT_TRUE(eventually(kPatience, "a worker to be busy", [&] { return pool.counters().busy == 1; }));
    pid_t victim = pool.pids().front();  // the busy ones are listed first
    // Others go on meanwhile.
    for (int k = 0; k < 10; ++k) EXPECT_TRUE(import_with(pool, kTetrahedron));
    ASSERT_EQ(::kill(victim, signal), 0);
    if (signal == SIGKILL) {  // A kill from outside is followed by another attempt.
      victim = next_reader(pool, victim);
      ASSERT_EQ(::kill(victim, signal), 0);
    }
    const Expected<Mesh> result = doomed.get();
    ASSERT_FALSE(result);
    // A signal from outside says nothing about the file: the kernel may be short of memory.
    const bool outside = signal == SIGKILL;
    EXPECT_EQ(result.error().code, outside ? ErrorCode::kOverloaded : ErrorCode::kImporterCrashed);
    EXPECT_EQ(result.error().retry_after.count() > 0, outside);
#ifdef FRACTURE_SANITIZED  // The sanitizer's handlers turn the signal into an exit.
    if (signal != SIGSEGV)
#endif
      EXPECT_THAT(result.error().detail, HasSubstr("signal " + std::to_string(signal)));
    EXPECT_EQ(pool.counters().crashed, outside ? 0u : 1u);
    EXPECT_EQ(pool.counters().no_room, 1u);
    for (const pid_t pid : pool.pids()) EXPECT_NE(pid, victim);
    EXPECT_TRUE(import_with(pool, kTetrahedron));
  }
  EXPECT_TRUE(settles(pool));
}

// A kernel that is short of memory kills a reader that waits, or one in the middle of a file.
TEST(ImportPool, AFileWhoseReaderSomebodyElseKilledIsReadByAnother) {
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
  ASSERT_EQ(::kill(pool.pids().at(0), SIGKILL), 0);
  EXPECT_TRUE(import_with(pool, kTetrahedron)) << "the worker was dead before";
  ASSERT_TRUE(settles(pool));
  const pid_t stopped = pool.pids().at(0);
  ASSERT_EQ(::kill(stopped, SIGSTOP), 0);
  auto read = std::async(std::launch::async, [&] { return import_with(pool, kTetrahedron); });
  EXPECT_TRUE(eventually(kPatience, "a worker to be busy", [&] { return pool.counters().busy == 1; }));
  EXPECT_EQ(::kill(stopped, SIGKILL), 0);
  EXPECT_TRUE(read.get()) << "the worker died over the file";
  EXPECT_TRUE(settles(pool));
  EXPECT_EQ(pool.counters().imported, 2u);
  EXPECT_EQ(pool.counters().crashed, 0u);
  EXPECT_EQ(pool.counters().started, 5u) << "one at the start, and one after each end";
}

// A compromised reader may ignore SIGXCPU. The SIGKILL that follows is then its own fault.
TEST(ImportPool, AReaderThatIsDeafToItsLimitIsNoVictim) {
  ImportPoolConfig config = config_of(FRACTURE_MISBEHAVING_PROGRAM, 1);
  config.worker.cpu = 1s;
  ImportPool pool(config);
  const rlimit second_alone{2, 2};  // as if the first signal were ignored
  ASSERT_EQ(::prlimit(pool.pids().at(0), RLIMIT_CPU, &second_alone, nullptr), 0);
  const Expected<Mesh> spun = import_with(pool, "! spin");
  ASSERT_FALSE(spun);
  EXPECT_EQ(spun.error().code, ErrorCode::kImporterLimit) << spun.error().detail;
  EXPECT_EQ(spun.error().extra->value("limit", ""), "cpu");
  EXPECT_EQ(pool.counters().limited, 1u);
  ASSERT_TRUE(settles(pool));
  EXPECT_EQ(pool.counters().started, 2u) << "it was not tried again";
  EXPECT_FALSE(import_with(pool, "! spin"));
  EXPECT_EQ(pool.counters().remembered, 1u);
}

// This is how `bake` reads its user's files.
TEST(ImportPool, FilesOfOneOwnerMayShareAProcessUntilOneGoesWrong) {
  ImportPoolConfig config = config_of(FRACTURE_MISBEHAVING_PROGRAM, 1);
  config.files_per_worker = 3;
  ImportPool pool(config);
  const auto started_after = [&](const std::string& file, bool good) {
    EXPECT_EQ(import_with(pool, file).has_value(), good) << file;
    EXPECT_TRUE(settles(pool));
    return pool.counters().started;
  };
  const pid_t first = pool.pids().at(0);
  EXPECT_EQ(started_after(kTetrahedron, true), 1u);
  EXPECT_EQ(started_after("what no reader knows", false), 1u) << "a refusal is an answer";
  EXPECT_EQ(pool.pids().at(0), first);
  EXPECT_EQ(started_after(kTetrahedron, true), 2u) << "it had three files";
  EXPECT_EQ(started_after(kTetrahedron, true), 2u);
  EXPECT_EQ(started_after("! null", false), 4u) << "it was read again by one that had read nothing before";
  EXPECT_EQ(pool.counters().crashed, 1u);
  EXPECT_EQ(started_after(kTetrahedron, true), 4u);
}

TEST(ImportPool, EveryWayToDieHasItsError) {
  ImportPoolConfig config = config_of(FRACTURE_MISBEHAVING_PROGRAM, 1);
  config.worker.cpu = 1s;
  ImportPool pool(config);
  const auto error_of = [&](const char* command) {
    const Expected<Mesh> result = import_with(pool, command);
    EXPECT_FALSE(result) << command;
    const Error error = result ? Error{} : result.error();
    EXPECT_TRUE(import_with(pool, kTetrahedron)) << "after " << command;
    return error;
  };
#ifndef FRACTURE_SANITIZED  // The sanitizer's handlers turn the signal and the exit into another exit.
  EXPECT_THAT(error_of("! exit").detail, HasSubstr("exit code 7"));
  EXPECT_THAT(error_of("! null").detail, HasSubstr("signal 11"));
#endif
  EXPECT_EQ(error_of("! null").code, ErrorCode::kImporterCrashed);
  EXPECT_EQ(error_of("! exit").code, ErrorCode::kImporterCrashed);
  EXPECT_THAT(error_of("! lie").detail, HasSubstr("names no vertex"));
  EXPECT_THAT(error_of("! lie about code").detail, HasSubstr("code that imports do not use"));
  // 1.1 GiB, although the limits allow three times 256 MiB. The limit of output, of memory or of the reply
  // ends it.
  EXPECT_EQ(error_of("! unfold").code, ErrorCode::kImporterLimit);
  const Error spun = error_of("! spin");
  EXPECT_EQ(spun.code, ErrorCode::kImporterLimit) << spun.detail;
  EXPECT_EQ(spun.extra->value("limit", ""), "cpu");
  const ImportCounters counters = pool.counters();
  EXPECT_EQ(counters.limited, 2u);
  EXPECT_GE(counters.crashed, 4u);
  EXPECT_TRUE(settles(pool));
}

TEST(ImportPool, MemoryIsLimitedAndTheWorkerLivesOn) {
#ifdef FRACTURE_SANITIZED
  GTEST_SKIP() << "the sanitizers reserve terabytes: no limit of the address space";
#else
  ImportPoolConfig config = config_of(FRACTURE_MISBEHAVING_PROGRAM, 1);
  config.worker.memory_bytes = 512u << 20;
  ImportPool pool(config);
  const Expected<Mesh> greedy = import_with(pool, "! memory");
  ASSERT_FALSE(greedy);
  EXPECT_EQ(greedy.error().code, ErrorCode::kImporterLimit);
  EXPECT_EQ(greedy.error().extra->value("limit", ""), "memory");
  EXPECT_TRUE(import_with(pool, kTetrahedron));
  EXPECT_EQ(pool.counters().crashed, 0u);
#endif
}

TEST(ImportPool, DeadlineAndCancelKillTheWorkerAndFreeItsPlace) {
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
  Execution late;
  late.deadline = std::chrono::steady_clock::now() + 50ms;
  try {
    (void)import_with(pool, "! spin", late);
    FAIL() << "it should have been interrupted";
  } catch (const Interrupted& interrupted) {
    EXPECT_EQ(interrupted.code, ErrorCode::kDeadlineExceeded);
  }
  std::stop_source stop;
  Execution cancelled;
  cancelled.stop = stop.get_token();
  std::thread canceller([&] {
    EXPECT_TRUE(eventually(kPatience, "a worker to be busy", [&] { return pool.counters().busy == 1; }));
    stop.request_stop();
  });
  EXPECT_THROW((void)import_with(pool, "! hang", cancelled), Interrupted);
  canceller.join();
  EXPECT_EQ(pool.counters().interrupted, 2u);
  EXPECT_TRUE(import_with(pool, kTetrahedron));
  EXPECT_TRUE(settles(pool)) << "the killed ones are reaped";
}

TEST(ImportPool, AWaitingImportIsCancelledToo) {
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
  std::stop_source stop;
  Execution cancelled;
  cancelled.stop = stop.get_token();
  auto hanging = std::async(std::launch::async,
                            [&] { EXPECT_THROW((void)import_with(pool, "! hang", cancelled), Interrupted); });
  ASSERT_TRUE(eventually(kPatience, "a worker to be busy", [&] { return pool.counters().busy == 1; }));
  Execution impatient;
  impatient.deadline = std::chrono::steady_clock::now() + 30ms;
  EXPECT_THROW((void)import_with(pool, kTetrahedron, impatient), Interrupted);
  stop.request_stop();
  hanging.get();
}

TEST(ImportPool, TheSandboxOpensNothingAndReachesNobody) {
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 1));
  if (pool.hello().seccomp == 0) GTEST_SKIP() << "this machine allows no seccomp filter";
  for (const auto& [call, error] :
       {std::pair{"open", EACCES}, std::pair{"create", EACCES}, std::pair{"socket", EPERM},
        std::pair{"fork", EPERM}, std::pair{"exec", EPERM}, std::pair{"kill", EPERM},
        std::pair{"code", EPERM}}) {
    const Expected<Mesh> told = import_with(pool, std::string("! try ") + call);
    ASSERT_FALSE(told);
    EXPECT_EQ(told.error().detail, "errno " + std::to_string(error)) << call;
  }
  EXPECT_FALSE(fs::exists("/tmp/fracture-import-was-here"));
}

TEST(ImportPool, WorkersHaveNoEnvironmentAndNoDescriptorsOfTheServer) {
  const int ours = ::open("/dev/null", O_RDONLY);  // without close-on-exec, like a careless library
  ImportPool pool(config_of(FRACTURE_IMPORT_PROGRAM, 1));
  const std::string proc = "/proc/" + std::to_string(pool.pids().at(0));
  std::ifstream status(proc + "/status");
  const std::string text{std::istreambuf_iterator<char>(status), {}};
  EXPECT_THAT(text, HasSubstr("NoNewPrivs:\t1"));
  if (pool.hello().seccomp == 1) {
    EXPECT_THAT(text, HasSubstr("Seccomp:\t2"));
  }
  // The process is not dumpable, so /proc shows its descriptors to root only.
  std::error_code error;
  std::size_t descriptors = 0;
  for (fs::directory_iterator it(proc + "/fd", error), end; !error && it != end; it.increment(error))
    ++descriptors;
  if (!error) {
    EXPECT_EQ(descriptors, 4u) << "0, 1, 2 and its socket";
  }
  ::close(ours);
}

TEST(ImportPool, LeaksNoDescriptorsAndNoProcesses) {
  {
    ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 2));
    EXPECT_TRUE(import_with(pool, kTetrahedron));
    // While a worker starts, both ends of its socket are open here.
    ASSERT_TRUE(settles(pool));
    const std::size_t per_worker = open_descriptors() - static_cast<std::size_t>(pool.counters().workers);
    for (int k = 0; k < sized(6, 20); ++k) {  // each one a different file, which is not remembered
      const ImportFile part{std::to_string(k), {}};
      const auto died = [&](const char* command) {
        const Expected<Mesh> mesh = pool.import(bytes_of(command), MeshFormat::kOff, std::span(&part, 1), {},
                                                {}, digest_of(command, std::span(&part, 1)));
        return !mesh && mesh.error().code == ErrorCode::kImporterCrashed;
      };
      EXPECT_TRUE(import_with(pool, kTetrahedron));
      EXPECT_TRUE(died("! exit"));
      EXPECT_TRUE(died("! lie"));
    }
    ASSERT_TRUE(settles(pool));
    EXPECT_EQ(open_descriptors() - static_cast<std::size_t>(pool.counters().workers), per_worker);
  }
  EXPECT_EQ(children(), 0u);
}

TEST(ImportPool, ManyThreadsShareFewWorkers) {
  ImportPool pool(config_of(FRACTURE_MISBEHAVING_PROGRAM, 2));
  std::vector<std::thread> threads;
  std::atomic<int> good{0}, crashed{0};
  const int each = sized(8, 25);
  for (int t = 0; t < 8; ++t)
    threads.emplace_back([&, t] {
      for (int k = 0; k < each; ++k) {
        const bool bad = (t + k) % 8 == 0;
        const ImportFile part{std::to_string(t * each + k), {}};  // so that a bad file is not remembered
        const std::string bytes = bad ? "! exit" : kTetrahedron;
        const Expected<Mesh> result = pool.import(bytes_of(bytes), MeshFormat::kOff, std::span(&part, 1), {},
                                                  {}, digest_of(bytes, std::span(&part, 1)));
        good += result.has_value();
        crashed += !result && result.error().code == ErrorCode::kImporterCrashed;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(good + crashed, 8 * each);
  EXPECT_EQ(pool.counters().imported, static_cast<std::uint64_t>(good));
  EXPECT_EQ(pool.counters().crashed, static_cast<std::uint64_t>(crashed));
  EXPECT_EQ(crashed, each);
  EXPECT_LE(pool.counters().workers, 2);
}

TEST(ImportPool, AProgramThatIsNoWorkerIsSaidToBeThat) {
  const auto reason = [](const char* program) -> std::string {
    try {
      ImportPool pool(config_of(program));
      return "it started";
    } catch (const std::exception& e) {
      return e.what();
    }
  };
  EXPECT_THAT(reason("/nonexistent/fracture-import"), HasSubstr("/nonexistent/fracture-import"));
  EXPECT_THAT(reason("/bin/true"), HasSubstr("does not start"));
  EXPECT_EQ(children(), 0u);
}

}  // namespace
}  // namespace fracture::test
