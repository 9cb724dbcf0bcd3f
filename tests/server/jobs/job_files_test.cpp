// The files of jobs: permissions and deletion.
#include <atomic>
#include <thread>

#include "tests/server/jobs/job_folder_fixture.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

TEST_F(Folder, OnlyTheServersUserReadsItsFiles) {
  fs::create_directories(folder / "records");  // as an earlier release left it
  fs::permissions(folder / "records", fs::perms::all);
  TakenFolder f(config());
  ASSERT_TRUE(put(f, record(1)));
  f.begun(record(1).id);
  for (const char* kind : {"records", "meshes", "begun", "quarantine", "tmp"})
    EXPECT_EQ(fs::status(folder / kind).permissions() & fs::perms::all, fs::perms::owner_all) << kind;
  for (const char* kind : {"records", "meshes", "begun"}) {
    EXPECT_EQ(files(kind), 1u) << kind;
    for (const auto& file : fs::directory_iterator(folder / kind))
      EXPECT_EQ(file.status().permissions() & fs::perms::all, fs::perms::owner_read | fs::perms::owner_write)
          << file.path();
  }
}

/// Deleting a large file takes long. Here it takes until another job has its place and has written the same
/// mesh again.
TEST_F(Folder, WhileAMeshIsDeletedOthersGetPlacesAndWriteIt) {
  std::atomic<int> deletions{0};
  std::atomic<bool> written{false};
  JobFolderConfig slow = config();
  slow.before_delete = [&] {
    if (++deletions > 1) return;
    EXPECT_TRUE(eventually(kPatience, "another job's mesh", [&] { return written.load(); }))
        << "the deletion holds the lock";
  };
  TakenFolder f(slow);
  ASSERT_TRUE(put(f, record(1)));
  const std::string first = record(1).id;
  const std::uint64_t kept = f.figures().bytes;
  std::thread deletes([&] { f.remove(first); });
  EXPECT_TRUE(eventually(kPatience, "the deletion", [&] { return deletions == 1; }));
  EXPECT_EQ(f.figures().jobs, 0u);
  const JobRecord next = record(2, "bob");
  EXPECT_EQ(f.reserve(next, kNoShare), Room::kThere);
  EXPECT_EQ(f.figures().bytes, kept + 15'000) << "the old file counts until it is deleted";
  EXPECT_TRUE(f.write(next, request));
  written = true;
  deletes.join();
  EXPECT_EQ(files("meshes"), 1u) << "the new file was deleted";
  EXPECT_EQ(files("tmp"), 0u);
  EXPECT_TRUE(f.read_mesh(next.digest));
  EXPECT_EQ(f.figures().bytes, kept);
  f.remove(next.id);
  EXPECT_EQ(deletions, 2);
  EXPECT_EQ(f.figures().bytes, 0u);
  EXPECT_EQ(files("meshes"), 0u);
}

}  // namespace
}  // namespace fracture::test
