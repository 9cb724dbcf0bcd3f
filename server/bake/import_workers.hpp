// The import workers of commands that read the caller's own files.
#pragma once

#include <memory>

#include "server/import_worker/import_pool.hpp"

namespace fracture::bake {

/// For commands whose user owns the files: workers without a limit on their memory, so that a crash of a
/// reader is an error message. Throws std::runtime_error where they cannot be started.
std::shared_ptr<ImportPool> own_import_workers(int workers);

}  // namespace fracture::bake
