// What the commands exit with, in one table each.
//
// 0 done · 1 this machine stood in the way (a file, a port), or a server did not answer · 2 the command line is
// wrong · 3 the mesh or a parameter was refused · 4 a bug of ours · 130 interrupted. inspect has its own, for
// pipelines: 0 a closed solid as it is · 1 usable after repair · 2 refused · 3 the command line or the file was
// wrong · 4 a bug of ours. health: 0 healthy · 1 anything else, since a container's HEALTHCHECK knows no other.
#pragma once

#include <cstddef>

#include "common/base/error.hpp"
#include "server/bake/run.hpp"

namespace fracture::cli {

inline constexpr int kExitDone = 0, kExitSystem = 1, kExitUsage = 2, kExitRefused = 3, kExitInternal = 4,
                     kExitInterrupted = 130;

/// Of inspect.
inline constexpr int kInspectClosed = 0, kInspectRepaired = 1, kInspectRefused = 2, kInspectFailed = 3;

/// Of a bake: the worst that happened. `allowed`: so many inputs may be refused before that counts.
int exit_code(const bake::RunFigures& figures, std::size_t allowed);

/// Of inspect, where there is an error: one about the mesh, or about the request, which says nothing of the mesh.
int inspect_exit_code(ErrorCode code);

}  // namespace fracture::cli
