// A reproducible game without a window, against a server that the test starts.
#pragma once

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "client/app/headless.hpp"
#include "tests/server/support/server_process.hpp"

namespace fracture::app {

inline Options options_for(const test::ServeProcess& server, const std::string& scene, double seconds) {
  Options options;
  options.server.port = server.port;
  options.scene = scene;
  options.headless = options.fixed_step = true;
  options.seconds = seconds;
  return options;
}

inline nlohmann::json run(const Options& options) {
  Expected<nlohmann::json> summary = run_headless(options);
  if (!summary) throw std::runtime_error(summary.error().detail);
  return *summary;
}

}  // namespace fracture::app
