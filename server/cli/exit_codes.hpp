// What the commands exit with: the table is common/base/exit_codes.hpp.
#pragma once

#include <cstddef>

#include "common/base/error.hpp"
#include "common/base/exit_codes.hpp"
#include "server/bake/run.hpp"

namespace fracture::cli {

/// Of a bake: the worst that happened. `allowed`: so many inputs may be refused before that counts.
int exit_code(const bake::RunFigures& figures, std::size_t allowed);

/// Of a command that ends with one error.
int exit_code(ErrorCode code);

}  // namespace fracture::cli
