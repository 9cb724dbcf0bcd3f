// Meshes of several owners: a mesh is hidden from other owners, and equal bytes are kept once.
#include <gtest/gtest.h>

#include <string>

#include "server/service/mesh_store.hpp"
#include "tests/server/service/stored_mesh.hpp"

namespace fracture {
namespace {

using std::chrono::seconds;
using test::stored_mesh;
using Put = MeshStore::Put;
using Whose = MeshStore::Whose;

struct MeshOwners : testing::Test {
  MeshStore store{{.quota_bytes = 100'000, .ttl = seconds(1000)}};
  /// The memory of a stored mesh apart from its bytes.
  const std::uint64_t around = stored_mesh("a", 1)->held() - 1;
};

TEST_F(MeshOwners, EachSeesItsOwnAndAnAdministratorAll) {
  EXPECT_EQ(store.put(stored_mesh("a", 10), {"ana"}), Put::kCreated);
  EXPECT_TRUE(store.find("a", "ana", Whose::kOwn));
  EXPECT_FALSE(store.find("a", "bob", Whose::kOwn));
  EXPECT_FALSE(store.find("a", "", Whose::kOwn));
  EXPECT_TRUE(store.find("a", "boss", Whose::kAnybodys));
  EXPECT_FALSE(store.erase("a", "bob"));
  EXPECT_TRUE(store.find("a", "ana", Whose::kOwn));
}

TEST_F(MeshOwners, EqualUploadsHaveSeveralOwnersAndOneOfThemLeavingTakesNothingFromTheOther) {
  store.put(stored_mesh("a", 1000), {"ana"});
  const std::uint64_t once = store.figures().bytes;
  EXPECT_EQ(store.put(stored_mesh("a", 1000), {"bob"}), Put::kCreated)
      << "that it was there is not for bob to know";
  EXPECT_EQ(store.figures().bytes, once + around) << "its bytes once";
  EXPECT_EQ(store.figures().meshes, 1u);
  EXPECT_EQ(store.find("a", "ana", Whose::kOwn)->mesh.data(),
            store.find("a", "bob", Whose::kOwn)->mesh.data());
  EXPECT_EQ(store.bytes_of("bob"), store.bytes_of("ana")) << "each pays for it";
  EXPECT_TRUE(store.erase("a", "ana"));
  EXPECT_FALSE(store.find("a", "ana", Whose::kOwn));
  EXPECT_TRUE(store.find("a", "bob", Whose::kOwn));
  EXPECT_EQ(store.figures().bytes, once);
  EXPECT_TRUE(store.erase("a", "bob"));
  EXPECT_EQ(store.figures().bytes, 0u);
  EXPECT_EQ(store.bytes_of("bob"), 0u);
}

TEST_F(MeshOwners, FormatAndReportAreEachOwners) {
  auto first = std::make_shared<StoredMesh>(*stored_mesh("a", 10));
  first->format = MeshFormat::kObj;
  first->description = std::make_shared<const std::string>("of ana");
  auto second = std::make_shared<StoredMesh>(*stored_mesh("a", 10));
  second->format = MeshFormat::kStl;
  second->description = std::make_shared<const std::string>("of bob");
  store.put(first, {"ana"});
  store.put(second, {"bob"});
  EXPECT_EQ(store.find("a", "ana", Whose::kOwn)->format, MeshFormat::kObj);
  EXPECT_EQ(*store.find("a", "ana", Whose::kOwn)->description, "of ana");
  EXPECT_EQ(store.find("a", "bob", Whose::kOwn)->format, MeshFormat::kStl);
}

TEST_F(MeshOwners, WhoseDigestIsEqualButWhoseBytesAreNotIsHandedNoneOfTheOther) {
  store.put(stored_mesh("a", 10, 'x'), {"ana"});
  store.put(stored_mesh("a", 10, 'y'), {"bob"});
  EXPECT_EQ(static_cast<char>(store.find("a", "ana", Whose::kOwn)->mesh[0]), 'x');
  EXPECT_EQ(static_cast<char>(store.find("a", "bob", Whose::kOwn)->mesh[0]), 'y');
}

TEST_F(MeshOwners, OverItsShareAnOwnersLeastRecentlyUsedLeaves) {
  const MeshStore::Owner ana{"ana", 3 * (100 + around)};
  store.put(stored_mesh("x", 100, 'x'), {"bob"});
  for (const char* name : {"a", "b", "c"})
    EXPECT_EQ(store.put(stored_mesh(name, 100, *name), ana), Put::kCreated);
  EXPECT_TRUE(store.find("a", "ana", Whose::kOwn));
  EXPECT_EQ(store.put(stored_mesh("d", 100, 'd'), ana), Put::kCreated);
  EXPECT_FALSE(store.find("b", "ana", Whose::kOwn));
  EXPECT_TRUE(store.find("a", "ana", Whose::kOwn) && store.find("x", "bob", Whose::kOwn));
  EXPECT_EQ(store.put(stored_mesh("large", 5000), ana), Put::kOverShare);
  EXPECT_EQ(store.bytes_of("ana"), 3 * (100 + around));
}

TEST_F(MeshOwners, WhoHasMostMakesRoomForTheOthers) {
  store.put(stored_mesh("quiet", 5'000, 'q'), {"bob"});
  for (int k = 0; k < 100; ++k)
    store.put(stored_mesh("flood " + std::to_string(k), 5'000, static_cast<char>(k)), {"ana"});
  EXPECT_TRUE(store.find("quiet", "bob", Whose::kOwn)) << "the least recently used of all";
  EXPECT_LE(store.figures().bytes, 100'000u);
  EXPECT_GT(store.bytes_of("ana"), 80'000u);
}

TEST_F(MeshOwners, TheTimeToLiveIsOfEachOwner) {
  MeshStore brief({.quota_bytes = 100'000, .ttl = seconds(10)});
  const MeshStore::Clock::time_point start{};
  brief.put(stored_mesh("a", 10), {"ana"}, start);
  brief.put(stored_mesh("a", 10), {"bob"}, start + seconds(5));
  brief.sweep(start + seconds(10));
  EXPECT_FALSE(brief.find("a", "ana", Whose::kOwn, start + seconds(10)));
  EXPECT_TRUE(brief.find("a", "bob", Whose::kOwn, start + seconds(10)));
  brief.sweep(start + seconds(30));
  EXPECT_EQ(brief.figures().bytes, 0u);
}

}  // namespace
}  // namespace fracture
