// Pools of import workers for tests.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <thread>

#include "common/digest/digest.hpp"
#include "server/import_worker/import_pool.hpp"
#include "server/service/fair_queue.hpp"
#include "tests/import/make_files.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

inline ImportPoolConfig config_of(const char* program, int workers = 2) {
  ImportPoolConfig config;
  config.worker.program = program;
  config.workers = workers;
  return config;
}

inline const std::string kTetrahedron =
    "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

/// A digest by which the pool recognizes an input.
inline std::string digest_of(std::string_view bytes, std::span<const ImportFile> files = {}) {
  std::string list = sha256(bytes).hex();
  for (const ImportFile& file : files) list += sha256(file.name).hex() + sha256(file.bytes).hex();
  return sha256(list).hex();
}

inline Expected<Mesh> import_with(ImportPool& pool, std::string_view bytes, const Execution& execution = {},
                                  const Flow& flow = {}) {
  return pool.import(bytes_of(bytes), MeshFormat::kOff, {}, {}, execution, digest_of(bytes), {}, flow);
}

/// Waits for the worker that reads after `killed` has died. Returns its process id.
inline pid_t next_reader(const ImportPool& pool, pid_t killed) {
  pid_t next = -1;
  require_eventually(kPatience, "another worker to read", [&] {
    // Busy workers are listed first. A worker that is first both before and after the pool was busy is the
    // busy one.
    const std::vector<pid_t> before = pool.pids();
    if (before.empty() || pool.counters().busy != 1) return false;
    const std::vector<pid_t> after = pool.pids();
    next = before.front();
    return next != killed && !after.empty() && after.front() == next;
  });
  return next;
}

/// Number of children of this process, including zombies.
inline std::size_t children() {
  std::size_t count = 0;
  for (const auto& task : fs::directory_iterator("/proc/self/task")) {
    std::ifstream list(task.path() / "children");
    count += static_cast<std::size_t>(std::distance(std::istream_iterator<int>(list), {}));
  }
  return count;
}

/// Waits until no file is read and no worker starts or ends. The zygote and the workers that wait for a file
/// remain.
inline bool settles(const ImportPool& pool) {
  return eventually(kPatience, "the children to be gone", [&] {
    const ImportCounters c = pool.counters();
    return c.busy == 0 && c.starting == 0 && c.workers >= 1 &&
           static_cast<std::size_t>(c.workers) + 1 == children();
  });
}

}  // namespace fracture::test
