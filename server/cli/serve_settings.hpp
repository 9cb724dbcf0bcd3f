// The settings of `serve`.
#pragma once

#include <string>
#include <vector>

#include "server/cli/options.hpp"
#include "server/cli/settings.hpp"

namespace fracture::cli {

/// The table. The settings read and write `options`, which must outlive them.
std::vector<Setting> serve_settings(ServeOptions& options);

/// Takes the settings from flags, environment and `config_file` (empty: none), each judged alone. `given`
/// gets those that were given, each from where it counts.
void read_settings(ServeOptions& options, const std::vector<Setting>& settings, const GivenSettings& flags,
                   const std::string& config_file, std::vector<std::string>& errors,
                   GivenSettings* given = nullptr);

/// Takes the settings from flags, environment and `config_file` (empty: none), then judges them as a whole.
/// Every error there is, in sentences; none: `options` is ready to serve, within the memory that there is
/// (memory_plan.hpp). `given` as of read_settings().
std::vector<std::string> configure(ServeOptions& options, const std::vector<Setting>& settings,
                                   const GivenSettings& flags, const std::string& config_file,
                                   GivenSettings* given = nullptr);

/// What is inconsistent between settings that are each valid alone.
std::vector<std::string> inconsistencies(const ServeOptions& options);

}  // namespace fracture::cli
