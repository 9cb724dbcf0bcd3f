// The whole program; main() only calls run().
#pragma once

namespace fracture::cli {

/// Parses the command line and runs the command. Returns the exit code (exit_codes.hpp).
int run(int argc, char** argv);

}  // namespace fracture::cli
