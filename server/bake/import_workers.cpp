#include "server/bake/import_workers.hpp"

namespace fracture::bake {

std::shared_ptr<ImportPool> own_import_workers(int workers) {
  ImportPoolConfig config;
  config.workers = workers;
  config.worker.program = import_worker_beside_this_program();
  config.worker.memory_bytes = 0;
  config.worker.cpu = std::chrono::seconds(0);
  return std::make_shared<ImportPool>(config);
}

}  // namespace fracture::bake
