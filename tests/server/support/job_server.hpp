// A server that keeps its jobs in a folder, for tests of jobs.
#pragma once

#include <string>
#include <thread>
#include <utility>

#include "tests/server/support/gate.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {

inline const std::string kAsync = "Content-Type: model/gltf-binary\r\nPrefer: respond-async\r\n";

/// Waits until the job has that state. Returns its document.
inline nlohmann::json wait_for_state(TestServer& server, const std::string& job, const std::string& state,
                                     const std::string& fields = "") {
  nlohmann::json document;
  EXPECT_TRUE(eventually(kPatience, job + " to be " + state, [&] {
    document = server.get(job, fields).json();
    return document.is_object() && document.value("state", "") == state;
  })) << document.dump();
  return document;
}

/// Options with the disk tier and the jobs in the folder.
inline TestServerOptions durable(const TemporaryFolder& folder) {
  TestServerOptions options;
  options.threads = 4;
  options.service.tiers.folder = folder.path;
  options.jobs.folder = folder / "jobs";
  return options;
}

}  // namespace fracture::test
