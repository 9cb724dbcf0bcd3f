// Jobs that outlive their server. Here the server is shut down and the process stays; restart_test.cpp
// kills real servers.
#include <gtest/gtest.h>

#include <map>
#include <optional>

#include "tests/server/support/job_server.hpp"
#include "tests/server/support/odd_files.hpp"
#include "tests/server/support/tenant_file.hpp"

namespace fracture::test {
namespace {

namespace fs = std::filesystem;

std::size_t files_in(const std::string& folder) {
  std::size_t n = 0;
  for (const auto& file : fs::directory_iterator(folder)) n += file.is_regular_file();
  return n;
}

/// A killed process leaves the mark of a job that has begun.
void leave_mark(const TemporaryFolder& folder, const std::string& job) {
  std::ofstream(folder / "jobs/begun/" + job.substr(6), std::ios::app) << "x";
}

struct Durable : testing::Test {
  TemporaryFolder folder;
  Gate gate;
  /// Options of a server whose computations wait at the gate, including the jobs that it resumes.
  TestServerOptions gated() {
    TestServerOptions options = durable(folder);
    options.control = std::make_shared<FakeControl>();
    options.control->during_cut = gate.hook();
    return options;
  }
  /// Starts a job and stops the server while the job runs. Returns its address.
  std::string interrupted(const std::string& query = "?sites=5", const std::string& mesh = "mesh") {
    TestServer server(gated());
    const Reply accepted = server.post("/fracture" + query, mesh, kAsync);
    EXPECT_EQ(accepted.status, 202) << accepted.body;
    EXPECT_EQ(accepted.json().at("durable"), true);
    wait_for_state(server, accepted.header("location"), "running");
    return accepted.header("location");
  }
};

TEST_F(Durable, AJobThatWasRunningGoesOnUnderItsIdAndItsFilesLeave) {
  const std::string job = interrupted();
  EXPECT_EQ(files_in(folder / "jobs/meshes"), 1u);
  EXPECT_EQ(files_in(folder / "jobs/begun"), 0u) << "it was stopped, not lost";
  TestServer server(durable(folder));
  const auto done = wait_for_state(server, job, "done");
  const Reply result = server.get(done.at("result"));
  EXPECT_EQ(result.status, 200);
  EXPECT_EQ(result.body, server.post("/fracture?sites=5", "mesh").body);
  EXPECT_EQ(server.control->cuts, 1);
  EXPECT_EQ(server.api.jobs().figures().resumed, 1u);
  server.api.flush_jobs();
  EXPECT_EQ(files_in(folder / "jobs/meshes"), 0u);
  EXPECT_EQ(files_in(folder / "jobs/begun"), 0u);
  EXPECT_EQ(ask(server.port(), "DELETE", job).status, 204);
  server.api.flush_jobs();
  EXPECT_EQ(files_in(folder / "jobs/records"), 0u);
}

TEST_F(Durable, WhatAJobCameToSurvivesToo) {
  std::string done, failed, gone;
  {
    TestServer server(durable(folder));
    done = server.post("/fracture?sites=5", "mesh", kAsync).header("location");
    wait_for_state(server, done, "done");
    gone = server.post("/fracture?sites=6", "mesh", kAsync).header("location");
    wait_for_state(server, gone, "done");
    EXPECT_EQ(ask(server.port(), "DELETE", gone).status, 204);
    server.control->import = [](std::string_view) -> Expected<Mesh> {
      return fail(ErrorCode::kMalformedMesh, "broken at byte 7");
    };
    failed = server.post("/fracture", "another mesh", kAsync).header("location");
    wait_for_state(server, failed, "failed");
  }
  TestServer server(durable(folder));
  const auto document = server.get(done).json();
  EXPECT_EQ(document.at("state"), "done");
  EXPECT_EQ(server.get(document.at("result")).status, 200) << "from the disk tier";
  EXPECT_EQ(server.control->cuts, 0);
  EXPECT_EQ(server.get(failed).json().at("error").at("detail"), "broken at byte 7");
  EXPECT_EQ(server.get(gone).status, 404);
  EXPECT_EQ(server.get("/jobs").json().at("jobs").size(), 2u);
}

TEST_F(Durable, AJobThatTheServerEndedInTwiceHasFailed) {
  const std::string job = interrupted();
  leave_mark(folder, job);
  {
    TestServer server(gated());
    wait_for_state(server, job, "running");  // A single interruption does not fail a job.
  }
  leave_mark(folder, job);
  TestServer server(durable(folder));
  const auto failed = server.get(job).json();
  EXPECT_EQ(failed.at("state"), "failed");
  EXPECT_EQ(failed.at("error").at("type"), "/problems/job-lost");
  EXPECT_EQ(failed.at("error").at("status"), 500);
  EXPECT_EQ(server.get("/problems/job-lost").status, 200);
  EXPECT_EQ(server.control->cuts, 0);
}

/// The job that kills the server must be alone when it does, so that no other job is blamed.
TEST_F(Durable, SuspectsAreTriedAfterTheOthersAndOneByOne) {
  const std::string first = interrupted("?sites=5"), second = interrupted("?sites=6"),
                    innocent = interrupted("?sites=7");
  leave_mark(folder, first);
  leave_mark(folder, second);
  gate.arrived = 0;
  std::optional<TestServer> server(std::in_place, gated());
  // All three were interrupted in turn, because each server resumed the earlier ones.
  wait_for_state(*server, innocent, "running");
  EXPECT_EQ(server->get(first).json().at("state"), "queued");
  EXPECT_EQ(server->get(second).json().at("state"), "queued");
  EXPECT_EQ(gate.arrived, 1);
  gate.open = true;
  for (const std::string& job : {innocent, first, second}) wait_for_state(*server, job, "done");
}

/// Another process must not remove the mark of a process that died.
TEST_F(Durable, ASuspectThatWaitsThroughADrainStaysOne) {
  const std::string suspect = interrupted("?sites=5"), innocent = interrupted("?sites=7");
  leave_mark(folder, suspect);
  leave_mark(folder, innocent);
  {
    TestServer server(gated());  // One of the two begins; then all are told to stop.
    EXPECT_TRUE(eventually(kPatience, "one to run", [&] { return gate.arrived > 0; }));
  }
  EXPECT_EQ(files_in(folder / "jobs/begun"), 2u);
}

TEST_F(Durable, ACancelledJobStaysCancelled) {
  std::string job;
  {
    TestServer server(durable(folder));
    server.control->during_cut = gate.hook();
    job = server.post("/fracture", "mesh", kAsync).header("location");
    wait_for_state(server, job, "running");
    EXPECT_EQ(ask(server.port(), "DELETE", job).status, 204);
    wait_for_state(server, job, "cancelled");
  }
  EXPECT_EQ(files_in(folder / "jobs/meshes"), 0u);
  TestServer server(durable(folder));
  EXPECT_EQ(server.get(job).json().at("state"), "cancelled");
  server.dispatcher.wait_idle();
  EXPECT_EQ(server.control->cuts, 0);
}

TEST_F(Durable, AJobThatWaitsToGoOnCanBeCancelled) {
  const std::string job = interrupted();
  leave_mark(folder, job);  // a suspect, queued behind the one that runs
  const std::string other = interrupted("?sites=6");
  TestServer server(gated());
  wait_for_state(server, other, "running");
  EXPECT_EQ(ask(server.port(), "DELETE", job).status, 204);
  EXPECT_EQ(server.get(job).json().at("state"), "cancelled");
  gate.open = true;
  wait_for_state(server, other, "done");
  EXPECT_EQ(server.control->cuts, 1);
}

TEST_F(Durable, DamageCostsTheJobAndNothingElse) {
  const std::string job = interrupted("?sites=5", "one mesh"), other = interrupted("?sites=5", "two mesh");
  for (const auto& mesh : fs::directory_iterator(folder / "jobs/meshes"))
    if (mesh.path().filename().string().substr(0, 16) == job.substr(6, 16)) fs::resize_file(mesh.path(), 20);
  TestServer server(durable(folder));
  EXPECT_EQ(wait_for_state(server, job, "failed").at("error").at("type"), "/problems/job-lost");
  wait_for_state(server, other, "done");
  EXPECT_EQ(files_in(folder / "jobs/quarantine"), 1u);
}

TEST_F(Durable, WhatIsNotAFileDoesNotStopTheStart) {
  std::string done;
  {
    TestServer server(durable(folder));
    done = server.post("/fracture?sites=9", "mesh", kAsync).header("location");
    wait_for_state(server, done, "done");
  }
  const std::string job = interrupted();
  int number = 0;
  for (const Odd odd : kAllOdd) {
    const std::string digits = std::string(15, '1') + std::to_string(number++),
                      key = digits + digits + digits + digits;
    put_odd(odd, folder / "jobs/records/" + digits + "-" + digits);
    put_odd(odd, folder / "jobs/meshes/" + key);
    put_odd(odd, folder / "jobs/begun/" + digits + "-" + digits);
    put_odd(odd, folder / "11/" + key);
  }
  TestServer server(durable(folder));
  EXPECT_EQ(server.get("/jobs").json().at("jobs").size(), 2u);
  EXPECT_EQ(server.get(server.get(done).json().at("result")).status, 200);
  EXPECT_EQ(server.get(wait_for_state(server, job, "done").at("result")).status, 200);
}

TEST_F(Durable, AJobWhoseResultIsGoneSaysSo) {
  std::string job;
  {
    TestServer server(durable(folder));
    job = server.post("/fracture?sites=5", "mesh", kAsync).header("location");
    wait_for_state(server, job, "done");
  }
  for (const fs::path& entry : entries_in(folder.path)) fs::remove(entry);
  TestServer server(durable(folder));
  const auto lost = server.get(job).json();
  EXPECT_EQ(lost.at("state"), "failed") << lost.dump();
  EXPECT_EQ(lost.at("error").at("type"), "/problems/job-lost");
  EXPECT_FALSE(lost.contains("result"));
  EXPECT_EQ(server.post("/fracture?sites=5", "mesh").status, 200);
}

TEST_F(Durable, ManyJobsGoOnEachOnce) {
  std::vector<std::string> jobs;
  {
    TestServer server(durable(folder));
    server.control->during_cut = gate.hook();
    for (int seed = 0; seed < 40; ++seed)
      jobs.push_back(
          server.post("/fracture?seed=" + std::to_string(seed), "mesh", kAsync).header("location"));
  }
  EXPECT_EQ(files_in(folder / "jobs/records"), 40u);
  EXPECT_EQ(files_in(folder / "jobs/meshes"), 1u);
  TestServerOptions options = durable(folder);
  options.max_queue = 2;  // They wait for room in the queue like all others.
  TestServer server(options);
  for (const std::string& job : jobs) wait_for_state(server, job, "done");
  EXPECT_EQ(server.control->cuts, 40);
  server.api.flush_jobs();
  EXPECT_EQ(files_in(folder / "jobs/meshes"), 0u);
}

TEST_F(Durable, WhatIsAskedForIsTheSameAfterARestart) {
  std::map<std::string, std::string> addresses;  // the address of each job's result
  {
    TestServer server(durable(folder));
    const std::string of = server.post("/fracture?sites=5", "mesh").header("content-location").substr(11);
    server.control->during_cut = gate.hook();
    for (const std::string& query :
         {std::string("material=glass&mass=12.5"),
          std::string("pattern=impact&impacts=0,0,0&sites=30&seed=9007199254740991"),
          std::string("local_point=0.1,0.2,0.3&local_radius=0.25&local_sites=7"),
          "of=" + of + "&local_point=0.1,0,0&local_radius=0.2&delta=only",
          std::string("rough_amplitude=0.1&interior_color=%23ff8000")}) {
      const Reply accepted =
          server.post("/fracture?" + query, "mesh", kAsync + "Accept: model/gltf+json\r\n");
      ASSERT_EQ(accepted.status, 202) << query << accepted.body;
      std::ifstream file(folder / "jobs/records/" + accepted.header("location").substr(6), std::ios::binary);
      const auto record = decode_record(std::string(std::istreambuf_iterator<char>(file), {}));
      ASSERT_TRUE(record) << query;
      addresses[accepted.header("location")] = "/fractures/sha256:" + record->result_key;
    }
  }
  TestServer server(durable(folder));
  for (const auto& [job, address] : addresses) {
    EXPECT_EQ(wait_for_state(server, job, "done").at("result"), address);
    EXPECT_EQ(server.get(address, "Accept: model/gltf+json\r\n").status, 200);
  }
}

TEST_F(Durable, WhatTheDiskTierHasNoRoomForIsComputedAgain) {
  TestServerOptions options = durable(folder);
  options.service.tiers.disk_bytes = 100;
  std::string job;
  {
    TestServer server(options);
    job = server.post("/fracture", "mesh", kAsync).header("location");
    wait_for_state(server, job, "done");
    server.api.flush_jobs();
    EXPECT_EQ(files_in(folder / "jobs/meshes"), 1u);
    EXPECT_EQ(files_in(folder / "jobs/begun"), 0u);
  }
  TestServer server(options);
  EXPECT_EQ(server.get(wait_for_state(server, job, "done").at("result")).status, 200);
  EXPECT_EQ(server.control->cuts, 1);
}

TEST_F(Durable, AFullFolderRefusesAndABrokenOneSaysThatItKeepsNothing) {
  TestServerOptions options = durable(folder);
  options.jobs.max_disk_bytes = 6 * 4096;
  TestServer server(options);
  server.control->during_cut = gate.hook();
  ASSERT_EQ(server.post("/fracture?seed=1", "mesh", kAsync).status, 202);
  ASSERT_EQ(server.post("/fracture?seed=2", "mesh", kAsync).status, 202) << "the mesh is there once";
  const Reply full = server.post("/fracture?seed=3", "mesh", kAsync);
  EXPECT_EQ(full.status, 429) << "half of the folder is one client's";
  EXPECT_EQ(full.problem(), "over-share");
  EXPECT_GE(std::atoi(full.header("retry-after").c_str()), 1);
  const auto from_another = [&](const std::string& target, const std::string& mesh) {
    return ask(server.port(), "POST", target, kAsync, mesh, "127.0.0.2");
  };
  EXPECT_EQ(from_another("/fracture?seed=4", "mesh").status, 202) << "of another client";
  EXPECT_EQ(
      ask(server.port(), "POST", "/fracture?seed=6", kAsync, std::string(9'000, 'm'), "127.0.0.3").status,
      503)
      << "it holds nothing, and there is no room";
  const Reply large = server.post("/fracture?seed=3", std::string(30'000, 'm'), kAsync);
  EXPECT_EQ(large.status, 202);
  EXPECT_EQ(large.json().at("durable"), false) << "it could never be kept";

  const TemporaryFolder elsewhere;
  TestServer broken(durable(elsewhere));
  broken.control->during_cut = gate.hook();
  fs::remove_all(elsewhere / "jobs/tmp");
  const Reply accepted = broken.post("/fracture", "mesh", kAsync);
  EXPECT_EQ(accepted.status, 202);
  EXPECT_EQ(accepted.json().at("durable"), false);
  gate.open = true;
  wait_for_state(broken, accepted.header("location"), "done");
}

TEST_F(Durable, NamesKeepTheirJobsAndAreChargedForThem) {
  TestServerOptions options = durable(folder);
  options.server.tokens = *tenants::TokenFile::parse(
      tenant_file({tenant("ana"), tenant("bob", {"read", "fracture", "bake"}, {{"stored_bytes", 3 * 4096}}),
                   tenant("boss", {"read", "admin"})}));
  std::string anas, bobs, finished;
  {
    TestServer server(options);
    finished = server.post("/fracture?sites=9", "mesh", kAsync + by("ana")).header("location");
    wait_for_state(server, finished, "done", by("ana"));
    server.control->during_cut = gate.hook();
    anas = server.post("/fracture", "mesh", kAsync + by("ana")).header("location");
    bobs = server.post("/fracture?seed=2", "mesh", kAsync + by("bob")).header("location");
    wait_for_state(server, anas, "running", by("ana"));
    ASSERT_EQ(server.post("/fracture?seed=3", "mesh", kAsync + by("bob")).status, 202);
    const Reply over = server.post("/fracture?seed=4", "mesh", kAsync + by("bob"));
    EXPECT_EQ(over.status, 429) << over.body;
    EXPECT_EQ(over.problem(), "over-share");
  }
  TestServer server(options);
  EXPECT_EQ(server.get(anas, by("bob")).status, 404);
  EXPECT_EQ(server.get(bobs, by("ana")).status, 404);
  const std::string result = wait_for_state(server, anas, "done", by("ana")).at("result");
  EXPECT_EQ(server.get(result, by("ana")).status, 200);
  EXPECT_EQ(server.get(result, by("bob")).status, 404);
  EXPECT_EQ(server.get(server.get(finished, by("ana")).json().at("result"), by("ana")).status, 200);
  wait_for_state(server, bobs, "done", by("boss"));
}

}  // namespace
}  // namespace fracture::test
