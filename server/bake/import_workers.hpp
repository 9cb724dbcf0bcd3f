// Import workers for commands that read the user's own files.
#pragma once

#include <memory>
#include <string>

#include "server/import_worker/import_pool.hpp"

namespace fracture::bake {

/// Starts workers without a memory limit, because the files belong to the user. If a reader crashes, the
/// program only reports an error. `memory_advice`: see ImportPoolConfig. Throws std::runtime_error if the workers cannot be started.
std::shared_ptr<ImportPool> own_import_workers(int workers, std::string memory_advice);

}  // namespace fracture::bake
