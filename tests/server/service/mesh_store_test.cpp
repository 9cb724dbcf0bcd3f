#include "server/service/mesh_store.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

#include <string>

#include "common/digest/digest.hpp"
#include "tests/server/service/stored_mesh.hpp"

namespace fracture {
namespace {

using std::chrono::seconds;
using test::stored_mesh;
using Put = MeshStore::Put;

/// The memory of a stored mesh apart from its bytes.
const std::uint64_t kAround = stored_mesh("a", 1)->held() - 1;

// Each for each quarter of a mebibyte.
TEST(MeshStore, ComparingAndCopyingPoll) {
  constexpr std::size_t kSize = std::size_t{8} << 20;
  int polls = 0;
  Execution execution;
  execution.watch = [&polls] { ++polls; };
  MeshStore store({.quota_bytes = 100u << 20});
  const auto put = [&](const std::string& owner) {
    return store.put(stored_mesh("a", kSize), {owner}, MeshStore::Clock::now(), execution);
  };
  EXPECT_EQ(put("ana"), Put::kCreated);
  EXPECT_EQ(polls, 0) << "there is nothing to compare with";
  EXPECT_EQ(put("bob"), Put::kCreated);
  EXPECT_EQ(polls, 32);
  EXPECT_LT(store.figures().bytes, 2 * kSize) << "equal bytes are kept once";

  polls = 0;
  const auto mesh = stored_mesh("b", kSize);
  FractureRequest request;
  request.mesh = mesh->mesh;
  request.owner = mesh->owner;
  const auto copy = stored_mesh_of(request, 2 * kSize, execution);
  EXPECT_EQ(polls, 32);
  EXPECT_TRUE(copy->owner != mesh->owner);
  EXPECT_EQ(copy->mesh.size(), kSize);
}

TEST(MeshStore, TheLeastRecentlyUsedLeavesWhenTheQuotaIsReached) {
  MeshStore store({.quota_bytes = 100 + 2 * kAround, .ttl = seconds(1000)});
  EXPECT_EQ(store.put(stored_mesh("a", 40)), Put::kCreated);
  EXPECT_EQ(store.put(stored_mesh("b", 40)), Put::kCreated);
  EXPECT_TRUE(store.find("a"));
  EXPECT_EQ(store.put(stored_mesh("c", 40)), Put::kCreated);
  EXPECT_FALSE(store.find("b"));
  EXPECT_TRUE(store.find("a"));
  EXPECT_EQ(store.figures().bytes, 80 + 2 * kAround);
  EXPECT_EQ(store.figures().evicted, 1u);
}

TEST(MeshStore, WhatIsOverTheQuotaAloneIsNotStoredAndMovesNobody) {
  MeshStore store({.quota_bytes = 100 + kAround, .ttl = seconds(1000)});
  store.put(stored_mesh("a", 100));
  EXPECT_EQ(store.put(stored_mesh("b", 101)), Put::kOverQuota);
  EXPECT_TRUE(store.find("a"));
}

TEST(MeshStore, AMeshThatIsPutAgainIsThereOnce) {
  MeshStore store({.quota_bytes = 100 + kAround, .ttl = seconds(1000)});
  store.put(stored_mesh("a", 60));
  EXPECT_EQ(store.put(stored_mesh("a", 60)), Put::kReplaced);
  EXPECT_EQ(store.figures().bytes, 60 + kAround);
  EXPECT_EQ(store.figures().meshes, 1u);
}

TEST(MeshStore, TheTimeToLiveBeginsAnewWithEachUse) {
  MeshStore store({.quota_bytes = 100 + 2 * kAround, .ttl = seconds(10)});
  const MeshStore::Clock::time_point start{};
  store.put(stored_mesh("a", 10), start);
  store.put(stored_mesh("b", 10), start);
  EXPECT_TRUE(store.find("a", start + seconds(9)));
  EXPECT_FALSE(store.find("b", start + seconds(10)));
  EXPECT_TRUE(store.find("a", start + seconds(18)));
  store.sweep(start + seconds(28));
  EXPECT_EQ(store.figures().meshes, 0u);
  EXPECT_EQ(store.figures().bytes, 0u);
  EXPECT_EQ(store.figures().expired, 2u);
}

#ifndef FRACTURE_SANITIZED  // The sanitizers' allocator counts differently.
TEST(MeshStore, ManySmallMeshesAreChargedWithTheTablesTheyStandIn) {
  MeshStore store({.quota_bytes = 100u << 20, .ttl = seconds(1000)});
  const std::string owner = "a name as long as names may be, which is 64 letters and no more.";
  const std::size_t before = ::mallinfo2().uordblks;
  for (int k = 0; k < 10'000; ++k) store.put(stored_mesh(sha256(std::to_string(k)).hex(), 100), {owner});
  const std::size_t held = ::mallinfo2().uordblks - before;
  EXPECT_EQ(store.figures().meshes, 10'000u);
  EXPECT_GE(store.figures().bytes, held);
  EXPECT_LT(store.figures().bytes, 2 * held);
}
#endif

TEST(MeshStore, WhoHoldsAMeshKeepsItsBytes) {
  MeshStore store({.quota_bytes = 100 + kAround, .ttl = seconds(1000)});
  store.put(stored_mesh("a", 3));
  const auto held = store.find("a");
  EXPECT_TRUE(store.erase("a"));
  EXPECT_FALSE(store.erase("a"));
  EXPECT_EQ(held->mesh.size(), 3u);
  EXPECT_EQ(static_cast<char>(held->mesh[2]), 'x');
}

TEST(MeshStore, ADeletedMeshCountsUntilNobodyHoldsIt) {
  MeshStore store({.quota_bytes = 100'000, .ttl = seconds(1000)});
  store.put(stored_mesh("a", 60'000));
  auto held = store.find("a");
  EXPECT_TRUE(store.erase("a"));
  EXPECT_EQ(store.figures().bytes, 60'000u);
  EXPECT_EQ(store.put(stored_mesh("b", 50'000)), Put::kNoRoom);
  EXPECT_EQ(store.put(stored_mesh("c", 30'000)), Put::kCreated);
  EXPECT_EQ(store.figures().bytes, 90'000 + kAround);
  held = nullptr;
  EXPECT_EQ(store.figures().bytes, 30'000 + kAround);
  EXPECT_EQ(store.put(stored_mesh("b", 50'000)), Put::kCreated);
}

/// Evicting a mesh in use would free nothing, so an unused one is evicted instead.
TEST(MeshStore, AMeshThatIsHeldIsNotEvicted) {
  MeshStore store({.quota_bytes = 100 + 2 * kAround, .ttl = seconds(1000)});
  store.put(stored_mesh("a", 40));
  store.put(stored_mesh("b", 40));
  const auto held = store.find("a");
  EXPECT_TRUE(store.find("b"));
  EXPECT_EQ(store.put(stored_mesh("c", 40)), Put::kCreated);
  EXPECT_TRUE(store.find("a"));
  EXPECT_FALSE(store.find("b"));
  EXPECT_EQ(store.put(stored_mesh("d", 100)), Put::kNoRoom);
  EXPECT_TRUE(store.find("c")) << "nothing leaves for a mesh that has no room even then";
  const auto both = store.find("c");
  EXPECT_EQ(store.put(stored_mesh("d", 40)), Put::kNoRoom);
  EXPECT_EQ(store.figures().evicted, 1u);
}

// Two owners store the same bytes, and a request uses the second one's mesh: to evict the first one's frees nothing.
TEST(MeshStore, AMeshThatSharesItsBytesWithOneInUseIsNotEvictedForThem) {
  MeshStore store({.quota_bytes = 60'000, .ttl = seconds(1000)});
  EXPECT_EQ(store.put(stored_mesh("a", 40'000), {"first"}), Put::kCreated);
  EXPECT_EQ(store.put(stored_mesh("a", 40'000), {"second"}), Put::kCreated);
  const auto held = store.find("a", "second", MeshStore::Whose::kOwn);
  EXPECT_EQ(store.put(stored_mesh("b", 30'000), {"third"}), Put::kNoRoom);
  EXPECT_TRUE(store.find("a", "first", MeshStore::Whose::kOwn));
  EXPECT_EQ(store.figures().evicted, 0u);
}

}  // namespace
}  // namespace fracture
