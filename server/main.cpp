// fracture-server: exact mesh fracture over HTTP (serve) or from the command line (bake).
#include <cstdio>
#include <cstring>
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
  if (const int reason = fracture::finish_printed(); reason != 0) {
    std::fprintf(stderr, "fracture-server: cannot write standard output: %s\n", std::strerror(reason));
    return fracture::kExitSystem;
  }
  return code;
}
