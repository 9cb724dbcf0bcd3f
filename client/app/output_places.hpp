// No file that the command line names is written over by another one of it.
#pragma once

#include <optional>
#include <string>

#include "client/app/options.hpp"

namespace fracture::app {

/// "--wav and --replay are both 'x'." where two of --record, --wav and --log are one place, or one is what is read (--replay,
/// a mesh), however it is spelt: links count, devices such as /dev/null do not.
std::optional<std::string> same_place(const Options& options);

/// A name in the folder that is not there yet: stem, date and time, and a number where that is needed.
std::string unused_name(const std::string& folder, const std::string& stem, const std::string& ending);

}  // namespace fracture::app
