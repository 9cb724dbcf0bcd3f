// The memory that a large upload reserves, and what it leaves to other clients.
#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "tests/server/service/reservations.hpp"
#include "tests/server/support/gate.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

/// One client stores a mesh that is predicted to need more than all of the working memory.
struct GreedyUpload : ReservationTest {
  Gate gate;
  const std::string large = std::string(96u << 20, 'x');  // 20 bytes of memory for each byte

  void SetUp() override {
    control->import = [hold = gate.hook_without_polls()](std::string_view) {
      hold(Execution{});
      return Expected<Mesh>(mesh_of(12));
    };
    EXPECT_FALSE(store("greedy", large.size(), {}, [](auto) {}));
    gate.wait_for(1);
  }
  std::optional<Error> store(const std::string& client, std::size_t bytes, Terms terms,
                             Dispatcher::MeshReply reply) {
    FractureRequest asked = request();
    asked.mesh = std::as_bytes(std::span(large).first(bytes));
    asked.owner = nullptr;
    terms.payer.flow = {client, 1};
    return dispatcher.prepare(std::move(asked), terms, std::move(reply));
  }
};

TEST_F(GreedyUpload, LeavesRoomForOthers) {
  EXPECT_EQ(dispatcher.figures().working_bytes, 768u << 20) << "three quarters of 1 GiB";
  EXPECT_FALSE(store("other", 3u << 19, {}, [](auto) {}));
  EXPECT_EQ(dispatcher.waiting_for_memory(), 0u);
  gate.open = true;
  dispatcher.wait_idle();
}

TEST_F(GreedyUpload, IsWaitedForByAnUploadThatLacksMemory) {
  std::atomic<bool> stored{false};
  EXPECT_FALSE(store("other", 20u << 20, {}, [&](auto mesh) { stored = mesh.has_value(); }));
  EXPECT_EQ(dispatcher.waiting_for_memory(), 1u);
  gate.open = true;
  EXPECT_TRUE(eventually(kPatience, "the other mesh", [&] { return stored.load(); }));
  dispatcher.wait_idle();
  EXPECT_EQ(dispatcher.figures().working_bytes, 0u);
}

TEST_F(GreedyUpload, IsNotWaitedForWhenTheOtherClientHasLeft) {
  std::stop_source gone;
  Terms terms;
  terms.gone = gone.get_token();
  std::atomic<int> replies{0};
  std::optional<ErrorCode> code;
  EXPECT_FALSE(store("other", 20u << 20, terms, [&](auto mesh) {
    if (!mesh) code = mesh.error().code;
    ++replies;
  }));
  EXPECT_EQ(dispatcher.waiting_for_memory(), 1u);
  gone.request_stop();
  EXPECT_EQ(replies, 1);
  EXPECT_EQ(code, ErrorCode::kCancelled);
  EXPECT_EQ(dispatcher.waiting_for_memory(), 0u);
  gate.open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(replies, 1);
}

}  // namespace
}  // namespace fracture::test
