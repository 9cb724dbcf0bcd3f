// The inside of an import worker: takes requests from its socket until that is closed.
#pragma once

#include <functional>

#include "server/import_worker/protocol.hpp"
#include "server/import_worker/sandbox.hpp"

namespace fracture {

using ImportFunction = std::function<Expected<Mesh>(const ImportJob&)>;

/// Calls import_mesh.
Expected<Mesh> import_job(const ImportJob& job);

/// Warms the readers up (so that nothing has to be loaded later), enters the sandbox, says hello and answers
/// requests. Returns the exit code: 0 when the server closed the connection.
int run_import_worker(int socket, const SandboxLimits& limits, const ImportFunction& import);

/// The program: `fracture-import MEMORY_BYTES` with its socket as descriptor 3.
int import_worker_main(int argc, char** argv, const ImportFunction& import);

}  // namespace fracture
