// Jobs as files: written jobs are found again, within limits, and damaged files are put aside.
#include <fstream>
#include <utility>

#include "tests/server/jobs/job_folder_fixture.hpp"
#include "tests/server/support/odd_files.hpp"

namespace fracture::test {
namespace {

TEST_F(Folder, WhatWasWrittenIsFoundAgainTheOldestFirst) {
  {
    TakenFolder f(config());
    for (const int number : {2, 1, 3}) ASSERT_TRUE(put(f, record(number)));
    EXPECT_EQ(files("meshes"), 1u) << "equal meshes are kept once";
    f.begun(record(1).id);
    JobRecord failed = record(3);
    failed.state = JobState::kFailed;
    failed.finished_at = failed.created + std::chrono::seconds(1);
    failed.error = Error{ErrorCode::kTooComplex, "too much", "sites", Figures(nlohmann::json{{"limit", 5}})};
    EXPECT_TRUE(f.write_end(failed));
  }
  TakenFolder again(config());
  const auto found = again.restore();
  ASSERT_EQ(found.size(), 3u);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(found[k].record.id, record(k + 1).id);
  EXPECT_EQ(found[0].begun, 1u);
  EXPECT_EQ(found[1].begun, 0u);
  const JobRecord& open = found[1].record;
  EXPECT_EQ(open.owner, "ana");
  EXPECT_EQ(open.created, record(2).created);
  EXPECT_EQ(open.patience, record(2).patience);
  EXPECT_EQ(open.format, MeshFormat::kObj);
  EXPECT_TRUE(open.parameters.empty()) << "nobody pays for the memory that they would take";
  const auto whole = again.read(open.id);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->parameters, record(2).parameters);
  EXPECT_EQ(open.result_key, record(2).result_key);
  const JobRecord& failed = found[2].record;
  EXPECT_EQ(failed.state, JobState::kFailed);
  ASSERT_TRUE(failed.error);
  EXPECT_EQ(failed.error->code, ErrorCode::kTooComplex);
  EXPECT_EQ(failed.error->extra->at("limit"), 5);
  const auto kept = again.read_mesh(open.digest);
  ASSERT_TRUE(kept);
  EXPECT_TRUE(std::equal(kept->mesh.begin(), kept->mesh.end(), request.mesh.begin(), request.mesh.end()));
  ASSERT_EQ(kept->files.size(), 1u);
  EXPECT_EQ(kept->files[0].name, "a name\nof two lines");
}

TEST_F(Folder, AMeshLeavesWithTheLastJobThatNeedsIt) {
  TakenFolder f(config());
  for (const int number : {1, 2}) ASSERT_TRUE(put(f, record(number)));
  JobRecord done = record(1);
  done.state = JobState::kDone;
  EXPECT_TRUE(f.write_end(done));
  EXPECT_EQ(files("meshes"), 1u);
  f.remove(record(2).id);
  EXPECT_EQ(files("meshes"), 0u);
  EXPECT_EQ(files("records"), 1u);
  f.remove(record(1).id);
  EXPECT_EQ(files("records"), 0u);
  EXPECT_EQ(f.figures().bytes, 0u);
  EXPECT_EQ(f.figures().jobs, 0u);
  EXPECT_EQ(files("tmp"), 0u);
}

TEST_F(Folder, BytesAreBoundedAndChargedToTheirOwner) {
  TakenFolder f(config(15'000 + 2 * 4096 + 100));
  EXPECT_EQ(f.reserve(record(1, "ana", 1u << 20), kNoShare), Room::kTooLarge);
  EXPECT_EQ(f.reserve(record(1), 10'000), Room::kTooLarge);
  ASSERT_EQ(f.reserve(record(1, "ana"), kNoShare), Room::kThere);
  EXPECT_EQ(f.bytes_of("ana"), 15'000u + 4096);
  ASSERT_EQ(f.reserve(record(2, "bob"), 20'000), Room::kThere) << "the same mesh is there once";
  EXPECT_EQ(f.bytes_of("bob"), 15'000u + 4096) << "and counts for each";
  EXPECT_EQ(f.reserve(record(3, "bob"), 20'000), Room::kOverShare);
  EXPECT_EQ(f.reserve(record(3, "ana"), kNoShare), Room::kFull);
  f.remove(record(2).id);
  EXPECT_EQ(f.bytes_of("bob"), 0u);
  EXPECT_EQ(f.reserve(record(3, "ana"), kNoShare), Room::kThere);
  JobRecord unfit = record(4);
  unfit.parameters = {{"interior", "\xff"}};
  EXPECT_EQ(f.reserve(unfit, kNoShare), Room::kUnfit);
}

TEST_F(Folder, EveryDamageOfARecordIsPutAside) {
  std::string whole;
  {
    TakenFolder f(config());
    ASSERT_TRUE(put(f, record(1)));
  }
  const std::string path = folder / "records/" + record(1).id;
  {
    std::ifstream file(path, std::ios::binary);
    whole.assign(std::istreambuf_iterator<char>(file), {});
  }
  std::vector<std::string> damages = {"", "fracture job 2\n" + whole.substr(15), whole + "x",
                                      whole.substr(0, whole.size() / 2)};
  for (std::size_t at = 0; at < whole.size(); at += 37) {
    damages.push_back(whole);
    damages.back()[at] ^= 1;
  }
  for (const std::string& damage : damages) {
    std::ofstream(path, std::ios::binary) << damage;
    TakenFolder f(config());
    EXPECT_TRUE(f.restore().empty()) << damage;
    EXPECT_FALSE(fs::exists(path));
    EXPECT_EQ(f.figures().quarantined, 1u);
    EXPECT_EQ(files("meshes"), 0u) << "nobody needs it any more";
    std::ofstream(path, std::ios::binary) << whole;  // for the next round
  }
  // Another job's record under this name, a folder, a name that is not an id, and a file of terabytes.
  fs::rename(path, folder / "records/" + record(9).id);
  fs::create_directory(path);
  std::ofstream(folder / "records/..x") << "x";
  std::ofstream(folder / "records/" + record(8).id) << "x";
  fs::resize_file(folder / "records/" + record(8).id, 4ull << 40);
  TakenFolder f(config());
  EXPECT_TRUE(f.restore().empty());
  EXPECT_EQ(f.figures().quarantined, 4u);
}

TEST_F(Folder, ADamagedMeshIsPutAside) {
  {
    TakenFolder f(config());
    ASSERT_TRUE(put(f, record(1)));
  }
  const std::string path = folder / "meshes/" + record(1).digest;
  for (const std::uint64_t size :
       {std::uint64_t{0}, std::uint64_t{20}, std::uint64_t{9'000}, std::uint64_t{4} << 40}) {
    if (!fs::exists(path)) {
      TakenFolder f(config());
      f.restore();
      ASSERT_TRUE(f.write(record(1), request));
    }
    fs::resize_file(path, size);
    TakenFolder f(config());
    ASSERT_EQ(f.restore().size(), 1u) << "the record is whole";
    EXPECT_FALSE(f.read_mesh(record(1).digest)) << size;
    EXPECT_FALSE(fs::exists(path));
  }
}

TEST_F(Folder, WhatIsNotAFileIsPutAsideAndItsNeighboursStay) {
  const auto entries = [this](const char* kind) {
    const auto all = fs::directory_iterator(folder / kind);
    return std::distance(begin(all), end(all));
  };
  for (const Odd odd : kAllOdd) {
    {
      TakenFolder f(config());
      ASSERT_TRUE(put(f, record(1)));
    }
    put_odd(odd, folder / "records/" + record(2).id);
    put_odd(odd, folder / "meshes/" + std::string(64, '0'));
    put_odd(odd, folder / "begun/" + record(3).id);
    TakenFolder f(config());
    const auto found = f.restore();
    ASSERT_EQ(found.size(), 1u) << static_cast<int>(odd);
    EXPECT_EQ(found[0].record.id, record(1).id);
    EXPECT_TRUE(f.read_mesh(record(1).digest));
    EXPECT_EQ(entries("records"), 1);
    EXPECT_EQ(entries("meshes"), 1);
    EXPECT_EQ(entries("begun"), 0);
  }
}

TEST_F(Folder, AMeshOrAMarkThatIsNotAFileIsWrittenAgain) {
  for (const Odd odd : kAllOdd) {
    const std::string mark = folder / "begun/" + record(1).id;
    {
      TakenFolder f(config());
      ASSERT_TRUE(put(f, record(1)));
    }
    put_odd(odd, folder / "meshes/" + record(1).digest);
    if (odd != Odd::kSparse) put_odd(odd, mark);
    TakenFolder f(config());
    const auto found = f.restore();
    ASSERT_EQ(found.size(), 1u) << static_cast<int>(odd);
    EXPECT_EQ(found[0].begun, 0u);
    EXPECT_FALSE(f.read_mesh(record(1).digest));
    ASSERT_TRUE(f.write(record(1), request));
    EXPECT_TRUE(f.read_mesh(record(1).digest));
    f.begun(record(1).id);
    EXPECT_EQ(fs::file_size(mark), 1u);
    put_odd(Odd::kFifo, mark);  // while the server runs
    f.begun(record(1).id);
    f.not_begun(record(1).id);
    EXPECT_FALSE(fs::exists(mark));
  }
}

TEST_F(Folder, WithKeysOnlyWhatTheySignedIsBelieved) {
  const std::string line(64, 'k'), other(64, 'o');
  JobFolderConfig signing = config();
  signing.keys = *FarmKeys::parse(line);
  {
    TakenFolder f(signing);
    ASSERT_TRUE(put(f, record(1)));
  }
  {
    TakenFolder f(signing);
    EXPECT_EQ(f.restore().size(), 1u);
  }
  signing.keys = *FarmKeys::parse(other);
  TakenFolder f(signing);
  EXPECT_TRUE(f.restore().empty());
  EXPECT_EQ(f.figures().quarantined, 1u);
}

TEST_F(Folder, MarksCountTheProcessesThatDidNotComeBack) {
  for (std::uint64_t ended = 0; ended < 3; ++ended) {
    TakenFolder f(config());
    const auto found = f.restore();
    if (ended == 0) {
      ASSERT_TRUE(put(f, record(1)));
    } else {
      ASSERT_EQ(found.size(), 1u);
      EXPECT_EQ(found[0].begun, ended);
    }
    f.begun(record(1).id);
    f.not_begun(record(1).id);  // A process that is told to stop removes its mark.
    f.begun(record(1).id);
  }
}

TEST_F(Folder, ItBelongsToOneServerUntilThatLetsItGo) {
  JobFolder second(config());
  {
    TakenFolder f(config());
    ASSERT_TRUE(put(f, record(1)));
    for (int k = 0; k < 3; ++k) EXPECT_EQ(second.take(), false);
  }
  EXPECT_EQ(second.take(), true);
  EXPECT_EQ(second.restore().size(), 1u);
  EXPECT_EQ(JobFolder(config()).take(), false);
}

TEST_F(Folder, OneThatCannotBeHadIsAnError) {
  std::ofstream(folder / "file") << "x";
  for (const std::string& bad :
       {std::string("/proc/no/such/folder"), folder / "file", folder / "file/below"}) {
    const Expected<bool> taken = JobFolder({bad, 1000, {}}).take();
    ASSERT_FALSE(taken) << bad;
    EXPECT_EQ(taken.error().code, ErrorCode::kFileAccess);
  }
}

TEST_F(Folder, AMeshCountsAsItIsOnTheDiskWhateverItsRecordSays) {
  {
    TakenFolder f(config(1u << 30));
    JobRecord lies = record(1);
    ASSERT_TRUE(put(f, lies));
    lies.mesh_bytes = 1ull << 40;
    std::ofstream(folder / "records/" + lies.id, std::ios::binary) << encode_record(lies);
  }
  TakenFolder f(config());
  const auto found = f.restore();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].record.mesh_bytes, fs::file_size(folder / "meshes/" + record(1).digest));
  EXPECT_LE(f.figures().bytes, 15'000u + 2 * 4096) << "there is room for others";
  EXPECT_TRUE(f.read_mesh(record(1).digest));
}

TEST_F(Folder, AMeshLargerThanTheFolderMayHoldIsPutAside) {
  {
    TakenFolder f(config());
    ASSERT_TRUE(put(f, record(1)));
  }
  const std::string path = folder / "meshes/" + record(1).digest;
  fs::resize_file(path, 4ull << 40);
  TakenFolder f(config());
  EXPECT_EQ(f.restore().size(), 1u);
  EXPECT_FALSE(fs::exists(path));
  EXPECT_LE(f.figures().bytes, 2u * 4096);
}

TEST_F(Folder, MoreJobsThanThereMayBeStayForALaterStart) {
  {
    TakenFolder f(config());
    for (int k = 1; k <= 5; ++k) ASSERT_TRUE(put(f, record(k)));
  }
  JobFolderConfig few = config();
  few.max_jobs = 3;
  {
    TakenFolder f(few);
    const auto found = f.restore();
    ASSERT_EQ(found.size(), 3u);
    for (const auto& job : found) f.remove(job.record.id);
    EXPECT_EQ(files("records"), 2u);
  }
  TakenFolder f(few);
  EXPECT_EQ(f.restore().size(), 2u);
}

/// A folder of 100,000 bytes. A client that holds h bytes next to m others may have h * (1 + m) <= free bytes
/// (FairShare with half as the share). The mesh takes 15,000 bytes, and each record 4,096.
TEST_F(Folder, AfterARestartTheSpaceOfAJobBelongsToItsClient) {
  const auto of = [this](const std::string& client, int number) {
    JobRecord r = record(number);
    r.client = client;
    return r;
  };
  {
    TakenFolder f(config(100'000));
    for (int k = 1; k <= 8; ++k) ASSERT_TRUE(put(f, of("address 192.0.2.1", k))) << k;
  }
  TakenFolder f(config(100'000));
  const auto found = f.restore();
  ASSERT_EQ(found.size(), 8u);
  EXPECT_EQ(found[0].record.client, "address 192.0.2.1");
  EXPECT_EQ(f.reserve(of("address 192.0.2.1", 9), kNoShare), Room::kOverPart) << "51,864 of 100,000 bytes";
  EXPECT_EQ(f.reserve(of("address 192.0.2.2", 10), kNoShare), Room::kThere) << "19,096 bytes, twice";
}

TEST_F(Folder, ADiskThatRefusesIsNoEnd) {
  TakenFolder first(config());
  ASSERT_EQ(first.reserve(record(1), kNoShare), Room::kThere);
  fs::remove_all(folder / "tmp");
  EXPECT_FALSE(first.write(record(1), request));
  EXPECT_EQ(first.figures().failures, 1u);
  first.begun(record(1).id);
  first.remove(record(1).id);
  EXPECT_EQ(first.figures().bytes, 0u);
}

}  // namespace
}  // namespace fracture::test
