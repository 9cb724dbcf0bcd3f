// A folder of jobs that a test has taken, and records of jobs for it.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

#include "server/jobs/job_folder.hpp"
#include "tests/server/support/temporary_folder.hpp"

namespace fracture::test {

namespace fs = std::filesystem;
using Room = JobFolder::Room;

inline constexpr std::uint64_t kNoShare = UINT64_MAX;

inline std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

/// A folder that this object has taken; no other server uses it.
struct TakenFolder : JobFolder {
  explicit TakenFolder(JobFolderConfig config) : JobFolder(std::move(config)) {
    EXPECT_TRUE(take().value_or(false)) << "another one has it";
  }
};

struct Folder : testing::Test {
  TemporaryFolder folder;
  const std::string mesh = std::string(10'000, 'm'), texture = std::string(5'000, 't');
  FractureRequest request{
      bytes_of(mesh), MeshFormat::kObj, {}, {{"a name\nof two lines", bytes_of(texture)}}};

  JobRecord record(int number, const std::string& owner = "ana", std::uint64_t mesh_bytes = 15'000) {
    JobRecord r;
    char id[34];
    std::snprintf(id, sizeof id, "0123456789abcdef-%016x", number);
    r.id = id;
    r.owner = owner;
    r.created += std::chrono::microseconds(1'700'000'000'000'000 + number);
    r.patience = std::chrono::milliseconds(5000);
    r.digest = digest_of(request).hex();
    r.mesh_bytes = mesh_bytes;
    r.format = MeshFormat::kObj;
    r.parameters = {{"sites", 7}};
    r.result_key = std::string(64, 'a');
    return r;
  }
  JobFolderConfig config(std::uint64_t bytes = 1u << 20) { return {folder.path, bytes, {}}; }
  bool put(JobFolder& f, const JobRecord& r) {
    return f.reserve(r, kNoShare) == Room::kThere && f.write(r, request);
  }
  std::size_t files(const char* kind) {
    std::size_t n = 0;
    for (const auto& file : fs::directory_iterator(folder / kind)) n += file.is_regular_file();
    return n;
  }
};

}  // namespace fracture::test
