// One allocation after the other fails on the threads that read and write: a connection is lost by it, and
// never the server's ear.
#include <gtest/gtest.h>
#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <thread>

#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace {

/// Allocations of other threads until one fails; 0: none does. Small ones never fail: Boost.Asio 1.81 takes
/// the lock of a half-made strand when the allocation of its mutex throws.
std::atomic<int> countdown{0};
constexpr std::size_t kSmall = 256;
thread_local bool is_spared = false;

void* allocate(std::size_t size) {
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
      client.receive();  // an answer, or the end
    }
    failed += countdown.exchange(0) <= 0;
    ASSERT_EQ(server.get("/version").status, 200) << "after allocation " << k;
    ASSERT_EQ(ask(server.server.admin_port(), "GET", "/livez").status, 200) << "after allocation " << k;
  }
  EXPECT_GE(failed, 5) << "no allocation failed";
  EXPECT_TRUE(
      eventually(kPatience, "the end of all connections", [&] { return server.server.connections() == 0; }));
}

}  // namespace
}  // namespace fracture::test
