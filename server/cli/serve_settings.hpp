// Settings of `serve`.
#pragma once

#include <string>
#include <vector>

#include "server/cli/options.hpp"
#include "server/cli/settings.hpp"

namespace fracture::cli {

/// Returns the table of settings. They read and write `options`, which must outlive them.
std::vector<Setting> serve_settings(ServeOptions& options);

/// Reads the settings from flags, environment and `config_file` (empty: none) and checks each one on its own.
/// `given` receives the settings that were given, each with the source that takes precedence.
void read_settings(ServeOptions& options, const std::vector<Setting>& settings, const GivenSettings& flags,
                   const std::string& config_file, std::vector<std::string>& errors,
                   GivenSettings* given = nullptr);

/// Reads the settings as read_settings() does, then checks them together. Returns a sentence for each error.
/// If there is none, `options` is ready to serve within the available memory (memory_plan.hpp). `given`: as
/// for read_settings().
std::vector<std::string> configure(ServeOptions& options, const std::vector<Setting>& settings,
                                   const GivenSettings& flags, const std::string& config_file,
                                   GivenSettings* given = nullptr);

/// Returns the contradictions between settings that are each valid on their own.
std::vector<std::string> inconsistencies(const ServeOptions& options);

}  // namespace fracture::cli
