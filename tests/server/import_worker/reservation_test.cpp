// How much memory an import reserves before its worker uses it: little for small files, more if they expand.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "common/digest/digest.hpp"
#include "common/mesh/material_library.hpp"
#include "server/import_worker/import_pool.hpp"
#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

/// A GLB with `count` instances of a tetrahedron. The instances take no bytes in the file.
[[maybe_unused]] std::string instances(std::uint32_t count) {
  Tetrahedron tet;
  tet.json["accessors"].push_back({{"componentType", 5126}, {"count", count}, {"type", "VEC3"}});
  tet.node()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
      tet.json["accessors"].size() - 1;
  return tet.glb();
}

struct ImportReservation : testing::Test {
  std::vector<std::uint64_t> asked;
  std::unique_ptr<Allowance> allowance;
  Execution execution;
  ImportPool pool{[] {
    ImportPoolConfig config;
    config.worker.program = FRACTURE_IMPORT_PROGRAM;
    config.memory_advice = "Raise --memory.";
    return config;
  }()};

  void allow(std::uint64_t limit) {
    allowance = std::make_unique<Allowance>(0, limit, [this, limit](std::uint64_t bytes) {
      if (bytes > limit) return Allowance::Answer::kNever;
      asked.push_back(bytes);
      return Allowance::Answer::kGranted;
    });
    execution.allowance = allowance.get();
  }
  Expected<Mesh> import(const std::string& glb) {
    return pool.import(bytes_of(glb), MeshFormat::kGlb, {}, {}, execution, sha256(glb).hex());
  }
};

#ifndef FRACTURE_SANITIZED  // With sanitizers a worker has no memory limit.

TEST_F(ImportReservation, ASmallFileTakesLittle) {
  allow(2ull << 30);
  ASSERT_TRUE(import(instances(10)));
  ASSERT_FALSE(asked.empty());
  EXPECT_LE(asked.back(), 32u << 20);
  EXPECT_EQ(allowance->bytes(), 0u) << "given back";
}

TEST_F(ImportReservation, ASmallObjIsReadAtOnce) {
  allow(2ull << 30);
  const char* const obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  for (int k = 0; k < 3; ++k)
    ASSERT_TRUE(
        pool.import(bytes_of(obj), MeshFormat::kObj, {}, {}, execution, sha256(std::string_view(obj)).hex()))
        << k;
  EXPECT_EQ(asked.size(), 1u) << "what is granted stays; no worker lacked memory and was given more";
}

TEST_F(ImportReservation, AFileThatUnfoldsIsGivenMoreAfterItIsSetAside) {
  allow(2ull << 30);
  const std::string glb = instances(300'000);
  EXPECT_LT(glb.size(), 2'000u);
  const Expected<Mesh> mesh = import(glb);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_EQ(mesh->triangles.size(), 1'200'000u);
  EXPECT_GE(asked.back(), mesh->triangles.size() * (sizeof(Vec3f) + 5 * sizeof(std::uint32_t)));
  EXPECT_EQ(pool.counters().imported, 1u);
  EXPECT_EQ(pool.counters().limited, 0u);
  EXPECT_EQ(pool.counters().crashed, 0u) << "a worker that lacked memory says so";
}

TEST_F(ImportReservation, ALongJsonIsReadThoughItsReaderEndsForWantOfMemoryAtFirst) {
  allow(2ull << 30);
  Tetrahedron tet;
  tet.json["materials"] = {{{"name", "m"}, {"extras", nlohmann::json::array()}}};
  for (int k = 0; k < 4'000'000; ++k) tet.json["materials"][0]["extras"].push_back(0);
  const Expected<Mesh> mesh = import(tet.glb());
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_EQ(mesh->library->materials[0]["name"], "m");
  EXPECT_EQ(pool.counters().crashed, 0u);
}

/// The estimate for this file exceeds the limit, but the file needs less. Other clients must be able to read meanwhile.
TEST_F(ImportReservation, ALargeFileFirstLeavesAQuarterToOthers) {
  constexpr std::uint64_t kLimit = 1792u << 20;
  allow(kLimit);
  constexpr std::uint32_t kTriangles = 2'000'000;
  std::string stl(84 + 50 * std::size_t{kTriangles}, '\0');
  std::memcpy(&stl[80], &kTriangles, sizeof kTriangles);
  (void)pool.import(bytes_of(stl), MeshFormat::kStl, {}, {}, execution, sha256(stl).hex());
  ASSERT_FALSE(asked.empty());
  EXPECT_LE(asked.front(), kLimit / 4 * 3 + (64u << 20));
}

TEST_F(ImportReservation, AFileThatUnfoldsBeyondWhatThereIsEndsWithItsLimit) {
  allow(64u << 20);
  const Expected<Mesh> mesh = import(instances(300'000));
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::kImporterLimit);
  EXPECT_EQ(mesh.error().extra->value("limit", ""), "memory");
  EXPECT_TRUE(mesh.error().detail.ends_with(" of memory for this file. Raise --memory."))
      << mesh.error().detail;
  EXPECT_EQ(pool.counters().limited, 1u) << "once, however often it was tried";
  EXPECT_TRUE(import(instances(10))) << "the next one is not concerned";
}

#endif

TEST_F(ImportReservation, AWorkerGoesBeforeTheServerWhereMemoryRunsOut) {
  for (const pid_t worker : pool.pids()) {
    std::ifstream file("/proc/" + std::to_string(worker) + "/oom_score_adj");
    int score = 0;
    file >> score;
    EXPECT_GE(score, 500);
  }
}

}  // namespace
}  // namespace fracture::test
