// One allocation after another fails on the threads that read and write. A failure may cost a connection, but
// the server still accepts the next one.
#include <gtest/gtest.h>
#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <thread>

#include "tests/server/support/jobs_host.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace {

/// The number of allocations on other threads until one fails; 0: none fails. Small allocations never fail,
/// because Boost.Asio 1.81 takes the lock of an unfinished strand if the allocation of its mutex throws.
std::atomic<int> countdown{0};
constexpr std::size_t kSmall = 256;
thread_local bool is_spared = false;
/// The number of allocations on this thread until one fails; 0: none fails. Allocations that JSON may need
/// never fail, because the destructor of a value in nlohmann-json 3.11 allocates.
constexpr std::size_t kJson = 800;
thread_local int own_countdown = 0;

void* allocate(std::size_t size) {
  if (size > kJson && own_countdown > 0 && --own_countdown == 0) throw std::bad_alloc();
  if (size > kSmall && countdown.load(std::memory_order_relaxed) > 0 && !is_spared &&
      countdown.fetch_sub(1) == 1)
    throw std::bad_alloc();
  if (void* const block = std::malloc(size ? size : 1)) return block;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) { return allocate(size); }
void* operator new[](std::size_t size) { return allocate(size); }
void operator delete(void* block) noexcept { std::free(block); }
void operator delete[](void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t) noexcept { std::free(block); }
void operator delete[](void* block, std::size_t) noexcept { std::free(block); }

namespace fracture::test {
namespace {

TEST(LackingMemory, WhereverAnAllocationFailsTheNextConnectionIsAccepted) {
  is_spared = true;
  TestServerOptions options;
  options.server.io_threads = 1;
  TestServer server(options);
  ASSERT_EQ(server.get("/version").status, 200) << "it listens";
  ASSERT_EQ(ask(server.server.admin_port(), "GET", "/livez").status, 200);
  int failed = 0;
  for (int k = 1; k <= 60; ++k) {
    countdown = k;
    {
      RawClient client(server.port());
      client.send("GET /version HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n");
      client.receive();  // an answer, or a closed connection
    }
    failed += countdown.exchange(0) <= 0;
    ASSERT_EQ(server.get("/version").status, 200) << "after allocation " << k;
    ASSERT_EQ(ask(server.server.admin_port(), "GET", "/livez").status, 200) << "after allocation " << k;
  }
  EXPECT_GE(failed, 5) << "no allocation failed";
  EXPECT_TRUE(
      eventually(kPatience, "the end of all connections", [&] { return server.server.connections() == 0; }));
}

TEST(LackingMemory, AJobThatCouldNotBeStartedLeavesNothing) {
  is_spared = true;
  const TemporaryFolder folder;
  JobsHost host(folder.path);
  host.control->during_cut = [](const Execution&) { is_spared = true; };
  std::uint64_t failed = 0;
  bool started = false;
  (void)keys_of(fracture_request("mesh", 0));  // builds the table of parameters
  for (int k = 1; !started; ++k) {
    ASSERT_LT(k, 2000);
    FractureRequest request = fracture_request("mesh", static_cast<std::uint64_t>(k));
    Terms terms;
    terms.priority = Priority::kBackground;
    terms.deadline = far_off();
    std::atomic<bool> accepted{false};
    own_countdown = k;
    try {
      const std::optional<Error> refused =
          host.jobs.start(std::move(request), terms, Jobs::Owner{}, [&](const JobView&) { accepted = true; });
      started = std::exchange(own_countdown, 0) > 0;
      failed += !started;
      EXPECT_FALSE(refused) << refused->detail;
      EXPECT_TRUE(eventually(kPatience, "the job to be accepted", [&] { return accepted.load(); }));
    } catch (const std::bad_alloc&) {
      own_countdown = 0;
      ++failed;
    }
    host.idle();
    ASSERT_EQ(host.jobs.figures().unfinished, 0u) << "after allocation " << k;
    ASSERT_EQ(host.dispatcher.working().used(), 0u) << "after allocation " << k;
  }
  EXPECT_GE(failed, 3u) << "no allocation failed";
}

}  // namespace
}  // namespace fracture::test
