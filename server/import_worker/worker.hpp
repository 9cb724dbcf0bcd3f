// The code that runs inside an import process. The server starts this program as the zygote, which warms up the readers and
// then only forks. Each fork reads files from the server in its sandbox. In a server, it reads a single file, so a file that
// takes over its process cannot affect any other file. In `bake`, where all files have one owner, it reads up to a hundred.
// The zygote itself never sees a byte of a file.
//
// The zygote has only one thread, so that a fork is a complete and consistent copy. It creates forks as its siblings
// (CLONE_PARENT). So the server itself can wait for them, see the signal that ended them, and kill them without the risk
// that their process id was reused.
#pragma once

#include <functional>

#include "common/mesh/mesh.hpp"
#include "server/import_worker/protocol.hpp"
#include "server/import_worker/sandbox.hpp"

namespace fracture {

using ImportFunction = std::function<Expected<Mesh>(const ImportJob&)>;

/// Calls import_mesh().
Expected<Mesh> import_job(const ImportJob& job);

/// Runs the zygote: warms up the readers (so that nothing needs to be loaded later), gives up rights that no fork needs, says
/// hello, and forks until the server closes the connection. `limits.memory_bytes`: memory that a fork may take in addition
/// to its memory at the start. Returns an exit code.
int run_zygote(int control, SandboxLimits limits, const ImportFunction& import);

/// Runs the program `fracture-import MEMORY_BYTES CPU_SECONDS`. Its socket is descriptor 3.
int import_worker_main(int argc, char** argv, const ImportFunction& import);

}  // namespace fracture
