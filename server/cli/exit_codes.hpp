// Exit codes of the commands. The table is in common/base/exit_codes.hpp.
#pragma once

#include <cstddef>

#include "common/base/error.hpp"
#include "common/base/exit_codes.hpp"
#include "server/bake/run.hpp"

namespace fracture::cli {

/// Returns the exit code of a bake, decided by its worst outcome. `allowed`: number of refused inputs that
/// still count as success.
int exit_code(const bake::RunFigures& figures, std::size_t allowed);

/// Returns the exit code of a command that fails with one error.
int exit_code(ErrorCode code);

}  // namespace fracture::cli
