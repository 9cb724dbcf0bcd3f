// fracture-server: exact mesh fracture over HTTP (serve) or from the command line (bake).
#include <cstdio>
#include <exception>

#include "common/base/exit_codes.hpp"
#include "common/base/printed_output.hpp"
#include "server/cli/program.hpp"

int main(int argc, char** argv) {
  fracture::occupy_standard_streams();
  int code = fracture::kExitInternal;
  try {
    code = fracture::cli::run(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "fracture-server: %s\n", e.what());
  }
  return fracture::finish_printed("fracture-server", code);
}
