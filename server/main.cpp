// fracture-server: exact mesh fracture over HTTP (serve) or from the command line (bake).
#include <cstdio>
#include <exception>

#include "common/base/allocator.hpp"
#include "server/cli/options.hpp"

int main(int argc, char** argv) {
  fracture::join_small_blocks_when_freed();
  try {
    return fracture::cli::run(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "fracture-server: %s\n", e.what());
    return fracture::cli::kExitInternal;
  }
}
