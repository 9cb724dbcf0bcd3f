// fracture-server: exact mesh fracture over HTTP (serve) or from the command line (bake).
#include <cstdio>
#include <exception>

#include "common/base/exit_codes.hpp"
#include "server/cli/program.hpp"

int main(int argc, char** argv) {
  try {
    return fracture::cli::run(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "fracture-server: %s\n", e.what());
    return fracture::kExitInternal;
  }
}
