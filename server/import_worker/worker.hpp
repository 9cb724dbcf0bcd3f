// The inside of an import process. The program that the server starts is the zygote: it warms the readers up
// and then only forks; each fork reads in its sandbox what the server gives it: of strangers one file, so that
// no other was there before, none comes after, and what a file does to its process it does to nobody else's
// (a bake's, whose files have one owner, a hundred). The zygote never saw a byte.
//
// The zygote has one thread, so that a fork has all there is, in a consistent state; and it forks siblings
// (CLONE_PARENT), so that the server itself waits for them, learns the signal that ended them and can kill
// them without a race for their number.
#pragma once

#include <functional>

#include "common/mesh/mesh.hpp"
#include "server/import_worker/protocol.hpp"
#include "server/import_worker/sandbox.hpp"

namespace fracture {

using ImportFunction = std::function<Expected<Mesh>(const ImportJob&)>;

/// Calls import_mesh.
Expected<Mesh> import_job(const ImportJob& job);

/// The zygote: warms the readers up (so that nothing has to be loaded later), gives up what no fork needs,
/// says hello and forks until the server closes the connection. `limits.memory_bytes`: what a fork may take beyond what it
/// begins with. An exit code.
int run_zygote(int control, SandboxLimits limits, const ImportFunction& import);

/// The program: `fracture-import MEMORY_BYTES CPU_SECONDS` with its socket as descriptor 3.
int import_worker_main(int argc, char** argv, const ImportFunction& import);

}  // namespace fracture
