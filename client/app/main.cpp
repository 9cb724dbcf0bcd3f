// fracture-client: the game, in a window or without one.
#include <cstdio>
#include <exception>

#include "client/app/headless.hpp"
#include "client/app/window.hpp"
#include "common/base/exit_codes.hpp"
#include "common/base/json_text.hpp"
#include "common/base/printable.hpp"
#include "common/base/printed_output.hpp"

namespace {

int run(int argc, char** argv) {
  try {
    const auto options = fracture::app::parse_options(argc, argv);
    if (!options) return options.error().code;
    if (!options->headless) return fracture::app::run_window(*options);
    const auto summary = fracture::app::run_headless(*options);
    if (!summary) {
      std::fprintf(stderr, "fracture-client: %s\n",
                   fracture::printable_lines(summary.error().detail).c_str());
      return fracture::kExitSystem;
    }
    if (options->json) std::printf("%s\n", fracture::json_text(*summary, 1).c_str());
    const auto& game = summary->at("game");
    if (const auto failures = game.at("failures").get<std::uint64_t>(); failures > 0) {
      std::fprintf(stderr, "fracture-client: %llu of %llu requests failed; the last error: %s\n",
                   static_cast<unsigned long long>(failures),
                   static_cast<unsigned long long>(game.at("requests").get<std::uint64_t>()),
                   fracture::printable_lines(game.at("trouble").get<std::string>()).c_str());
      if (game.at("answers") == 0) return fracture::kExitSystem;  // nothing in the result is as requested
    }
    const auto& diverged = game.at("diverged");
    if (diverged.is_null()) return fracture::kExitDone;
    std::fprintf(stderr, "fracture-client: step %s differs from the recording\n", diverged.dump().c_str());
    return fracture::kExitInternal;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fracture-client: %s\n", error.what());
    return fracture::kExitInternal;
  }
}

}  // namespace

int main(int argc, char** argv) {
  fracture::occupy_standard_streams();
  return fracture::finish_printed("fracture-client", run(argc, argv));
}
