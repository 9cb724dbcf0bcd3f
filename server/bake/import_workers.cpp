#include "server/bake/import_workers.hpp"

#include <chrono>
#include <utility>

namespace fracture::bake {
namespace {

/// Restarting a worker frees any memory that it has leaked. Starting a new process for every file would take
/// longer than reading a small file.
constexpr int kFilesPerWorker = 100;

}  // namespace

std::shared_ptr<ImportPool> own_import_workers(int workers, std::string memory_advice) {
  ImportPoolConfig config;
  config.workers = workers;
  config.files_per_worker = kFilesPerWorker;
  config.worker.program = import_worker_beside_this_program();
  config.worker.memory_bytes = 0;
  config.worker.cpu = std::chrono::seconds(0);
  config.memory_advice = std::move(memory_advice);
  return std::make_shared<ImportPool>(config);
}

}  // namespace fracture::bake
