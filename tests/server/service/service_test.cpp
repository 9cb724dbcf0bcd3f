#include "server/service/service.hpp"
#include "common/import/import.hpp"

#include <gtest/gtest.h>

#include <set>
#include <stop_token>

#include "common/contacts/contacts.hpp"
#include "server/service/mesh_report.hpp"
#include "tests/server/support/fake_engine.hpp"
#include "tests/server/support/figures_of.hpp"
#include "tests/server/support/fracture_request.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture {
namespace {

/// Returns how often `work` polls the execution that it is given.
template <class Work>
int polls_of(Work work) {
  int polls = 0;
  Execution execution;
  execution.watch = [&polls] { ++polls; };
  work(execution);
  return polls;
}

TEST(RequestKeys, HashingAMeshPolls) {
  const std::string mesh(16u << 20, 'x');
  FractureRequest request = test::fracture_request(mesh);
  EXPECT_GE(polls_of([&](const Execution& execution) { (void)digest_of(request, execution); }), 16);
  request.files.push_back({"a.bin", request.mesh});
  EXPECT_GE(polls_of([&](const Execution& execution) { (void)digest_of(request, execution); }), 32);
}

TEST(ResultTiersTest, HashingWhatTheDiskHasPolls) {
  const test::TemporaryFolder folder;
  TiersConfig config;
  config.folder = folder.path;
  ResultTiers tiers(config);
  const auto result = std::make_shared<FractureResult>();
  result->mesh_digest = "sha256:" + std::string(64, 'a');
  result->key = std::string(64, 'a');
  result->parameters = "{}";
  result->file.assign(16u << 20, 'x');
  result->file[0] = '{', result->file[1] = '}';
  result->figures = {0, 2};
  result->file_digest = sha256(std::as_bytes(std::span(result->file)));
  result->figures_digest = sha256("{}");
  ASSERT_TRUE(tiers.keep_on_disk(result));
  ResultTiers::Found found;
  EXPECT_GE(polls_of([&](const Execution& execution) { found = tiers.find(result->key, {}, execution); }),
            16);
  ASSERT_TRUE(found.result);
  EXPECT_EQ(found.result->file, result->file);
}

// A bar of 3 x 1 x 1 and a bar across it have a cube in common.
TEST(MeshReport, StatesTheVolumeWithOverlapsCountedOnce) {
  PreparedMesh mesh;
  mesh.solid = test::solid_of(test::joined(
      {test::box({-1.5, -0.5, -0.5}, {1.5, 0.5, 0.5}), test::box({-0.5, -1.5, -0.5}, {0.5, 1.5, 0.5})}));
  EXPECT_DOUBLE_EQ(mesh_report(mesh).at("volume_once").get<double>(), 6)
      << "without contacts, nothing is known to overlap";
  keep_contacts(mesh.solid, {}, {});
  const nlohmann::json report = mesh_report(mesh);
  EXPECT_NEAR(report.at("solid").at("volume").get<double>(), 6, 1e-12);
  EXPECT_NEAR(report.at("volume_once").get<double>(), 5, 1e-9);
}

using nlohmann::json;
using test::FakeControl;
using test::FakeEngine;

std::span<const std::byte> bytes(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

struct ServiceTest : testing::Test {
  std::shared_ptr<FakeControl> control = std::make_shared<FakeControl>();
  ServiceConfig config;
  FractureService service{config, std::make_unique<FakeEngine>(control)};

  FractureRequest request(std::string_view mesh, std::uint32_t sites = 50, std::uint64_t seed = 1) {
    FractureRequest r;
    r.mesh = bytes(mesh);
    r.parameters.fracture.sites = sites;
    r.parameters.fracture.seed = seed;
    return r;
  }
};

TEST_F(ServiceTest, TheSameRequestIsComputedOnceAndSharesOneBuffer) {
  const auto first = service.fracture(request("mesh"), {}), second = service.fracture(request("mesh"), {});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->result.get(), second->result.get());
  EXPECT_EQ(first->result_cache, CacheOutcome::kMissStored);
  EXPECT_EQ(second->result_cache, CacheOutcome::kHit);
  EXPECT_EQ(control->cuts, 1);
  EXPECT_EQ(service.find_result(first->result->key), first->result);
}

TEST_F(ServiceTest, ANewSeedReusesThePreparedMesh) {
  ASSERT_TRUE(service.fracture(request("mesh", 50, 1), {}));
  const auto second = service.fracture(request("mesh", 50, 2), {});
  ASSERT_TRUE(second);
  EXPECT_EQ(second->mesh_cache, CacheOutcome::kHit);
  EXPECT_EQ(second->diagram_cache, CacheOutcome::kMissStored);
  EXPECT_EQ(control->imports, 1);
  EXPECT_EQ(control->diagrams, 2);
}

TEST_F(ServiceTest, AnotherDualReusesTheTetrahedralization) {
  FractureRequest r = request("mesh");
  ASSERT_TRUE(service.fracture(r, {}));
  r.parameters.fracture.dual = Dual::kBarycenter;
  const auto second = service.fracture(r, {});
  ASSERT_TRUE(second);
  EXPECT_EQ(second->diagram_cache, CacheOutcome::kHit);
  EXPECT_EQ(control->cuts, 2);
}

TEST_F(ServiceTest, KeysDifferInEverythingThatMattersAndBeginWithTheMesh) {
  std::set<std::string> keys;
  const auto key_of = [&](const FractureRequest& r) { return service.fracture(r, {})->result->key; };
  FractureRequest r = request("mesh");
  keys.insert(key_of(r));
  r.format = MeshFormat::kObj;  // the same bytes read in another format
  keys.insert(key_of(r));
  keys.insert(key_of(request("mesh", 51)));
  keys.insert(key_of(request("mesh", 50, 2)));
  EXPECT_EQ(keys.size(), 4u);
  for (const std::string& key : keys) {
    EXPECT_EQ(key.size(), 64u);
    EXPECT_EQ(key.substr(0, 16), keys.begin()->substr(0, 16));
  }
  EXPECT_NE(key_of(request("other")).substr(0, 16), keys.begin()->substr(0, 16));
}

TEST_F(ServiceTest, FurtherFilesAreInTheDigestByNameAndBytesWhateverTheirOrder) {
  const auto digest_with = [&](std::vector<ImportFile> files) {
    FractureRequest r = request("mesh");
    r.files = std::move(files);
    return digest_of(r).hex();
  };
  const ImportFile a{"a.bin", bytes("1")}, b{"b.bin", bytes("2")};
  EXPECT_EQ(digest_with({}), sha256("mesh").hex());
  EXPECT_EQ(digest_with({a, b}), digest_with({b, a}));
  const std::set<std::string> distinct{digest_with({}), digest_with({a}), digest_with({a, b}),
                                       digest_with({{"a.bin", bytes("2")}, {"b.bin", bytes("1")}}),
                                       digest_with({{"c.bin", bytes("1")}})};
  EXPECT_EQ(distinct.size(), 5u);
  // Sorted by bytes, as clients sort: names with bytes beyond ASCII come last.
  const std::string umlaut = "\xc3\xa4.bin";
  const std::string list = "files\n" + sha256("mesh").hex() + "\n5 a.bin " + sha256("1").hex() + "\n6 " +
                           umlaut + " " + sha256("2").hex() + "\n";
  EXPECT_EQ(digest_with({{umlaut, bytes("2")}, a}), sha256("fracture files 2\n" + sha256(list).hex()).hex());
  FractureRequest with = request("mesh");
  with.files = {a};
  EXPECT_NE(service.fracture(with, {})->result->key, service.fracture(request("mesh"), {})->result->key);
}

TEST(ServiceKeys, NoMeshAloneHasTheDigestOfOneWithFiles) {
  // A list of names and digests with a tetrahedron in one name is a valid OBJ, because readers skip lines
  // that they do not know.
  const std::string name = "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
                    mesh = "{}", bytes = "b";
  FractureRequest several;
  several.mesh = std::as_bytes(std::span(mesh));
  several.files = {{name, std::as_bytes(std::span(bytes))}};
  const std::string list = "files\n" + sha256(mesh).hex() + "\n" + std::to_string(name.size()) + " " + name +
                           " " + sha256(bytes).hex() + "\n";
  FractureRequest alone;
  alone.mesh = std::as_bytes(std::span(list));
  EXPECT_TRUE(import_mesh(alone.mesh, MeshFormat::kObj, {}, {})) << "it is a mesh";
  EXPECT_NE(digest_of(alone), digest_of(several));
}

TEST_F(ServiceTest, TheFiguresAreThoseOfTheFile) {
  const auto answer = service.fracture(request("mesh", 7), {});
  EXPECT_EQ(test::figures_of(*answer->result).at("fragments"), 7);
  EXPECT_EQ(test::figures_of(*answer->result).at("mesh"), answer->result->mesh_digest);
}

TEST_F(ServiceTest, AnAnswerKeepsItsParametersAndWhatItComesTo) {
  const auto answer = service.fracture(request("mesh", 7), {});
  const json figures = test::figures_of(*answer->result);
  ASSERT_TRUE(answer->result->summary.has_value());
  EXPECT_EQ(json::parse(answer->result->parameters), figures.at("parameters"));
  EXPECT_EQ(answer->result->summary->certificate.fragments, 7u);
}

TEST(AnswerSummary, HasEachWarningOnceAndKnowsWhetherAPartitionIsPromised) {
  FracturedSolid made;
  made.set.certificate.open_edges = 3;
  made.report.remarks = {{"b", "a", "b"}, {"n", "n"}};
  made.report.dropped = {{"light", "Lamp", "why"}};
  const AnswerSummary partition = summary_of(made);
  EXPECT_EQ(partition.certificate.open_edges, 3u);
  EXPECT_EQ(partition.remarks, (Remarks{{"b", "a"}, {"n"}}));
  EXPECT_EQ(partition.dropped, made.report.dropped);
  EXPECT_TRUE(partition.partition && partition.judged);
  made.report.barycenter.emplace();
  EXPECT_FALSE(summary_of(made).partition);
}

TEST(AnswerSummary, IsReadFromAFileThatIsFromElsewhere) {
  const auto read = [](const json& figures) {
    const json document = {{"nodes", {{{"extras", {{"fracture", figures}}}}}}};
    const std::string text = document.dump();
    return summary_in(std::vector<std::uint8_t>(text.begin(), text.end()), OutputFormat::kGltf);
  };
  json figures = {
      {"bonds", json::object()},
      {"certificate",
       {{"open_edges", 1},
        {"unmirrored_caps", 2},
        {"volume_in", 3},
        {"volume_out", 3.5},
        {"relative_error", 0.25},
        {"fragments", 4}}},
      {"report",
       {{"warnings", {"w", "w"}},
        {"notes", {"n", "m", "n"}},
        {"dropped", json::array({{{"what", "light"}, {"name", "Lamp"}, {"reason", "why"}}, 7})}}}};
  const AnswerSummary summary = read(figures);
  EXPECT_EQ(summary.certificate.open_edges, 1u);
  EXPECT_EQ(summary.certificate.unmirrored_caps, 2u);
  EXPECT_EQ(summary.certificate.volume_in, 3);
  EXPECT_EQ(summary.certificate.volume_out, 3.5);
  EXPECT_EQ(summary.certificate.relative_error, 0.25);
  EXPECT_EQ(summary.certificate.fragments, 4u);
  EXPECT_EQ(summary.remarks, (Remarks{{"w"}, {"n", "m"}}));
  EXPECT_EQ(summary.dropped, (std::vector<Dropped>{{"light", "Lamp", "why"}}));
  EXPECT_TRUE(summary.partition && summary.judged);
  figures["report"]["barycenter"] = json::object();
  figures["certificate"].erase("unmirrored_caps");
  EXPECT_FALSE(read(figures).partition || read(figures).judged);
  figures["certificate"] = json::object();
  EXPECT_THROW(read(figures), InternalError) << "nothing says that it is closed";
  figures.erase("certificate");
  EXPECT_THROW(read(figures), InternalError);
  EXPECT_THROW(summary_in({}, OutputFormat::kGlb), InternalError);
}

TEST_F(ServiceTest, AMeshIsReadWithinTheSameMemoryForAReportAsForAnAnswer) {
  ServiceConfig limited = config;
  limited.max_bytes_per_job = 123u << 20;
  FractureService small{limited, std::make_unique<FakeEngine>(control)};
  std::vector<std::uint64_t> limits;
  control->during_import = [&](const Execution& execution) {
    limits.push_back(execution.allowance ? execution.allowance->limit() : 0);
  };
  EXPECT_TRUE(small.prepare(request("one"), {}));
  EXPECT_TRUE(small.fracture(request("two"), {}));
  EXPECT_TRUE(service.prepare(request("three"), {}));
  EXPECT_EQ(limits, (std::vector<std::uint64_t>{123u << 20, 123u << 20, 0}));
}

TEST_F(ServiceTest, ErrorsAreNotCached) {
  control->import = [&](std::string_view) -> Expected<Mesh> {
    if (control->imports == 1) return fail(ErrorCode::kMalformedMesh, "once");
    return Mesh{};
  };
  EXPECT_FALSE(service.fracture(request("mesh"), {}));
  EXPECT_TRUE(service.fracture(request("mesh"), {}));
}

TEST_F(ServiceTest, CancellationAndDeadlineComeBackAsErrors) {
  control->during_cut = [](const Execution& execution) { execution.poll(); };
  Execution late;
  late.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  EXPECT_EQ(service.fracture(request("mesh"), late).error().code, ErrorCode::kDeadlineExceeded);
  std::stop_source stop;
  stop.request_stop();
  Execution stopped;
  stopped.stop = stop.get_token();
  EXPECT_EQ(service.fracture(request("mesh"), stopped).error().code, ErrorCode::kCancelled);
}

TEST_F(ServiceTest, NoBytesIsAnEmptyBody) {
  EXPECT_EQ(service.fracture(request(""), {}).error().code, ErrorCode::kEmptyBody);
}

}  // namespace
}  // namespace fracture
