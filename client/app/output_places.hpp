// Checks that no output file on the command line overwrites another file named there.
#pragma once

#include <optional>
#include <string>

#include "client/app/options.hpp"

namespace fracture::app {

/// Returns "--wav and --replay are both 'x'. …" if two of --record, --wav and --log name the same file, or
/// if one of them names an input (--replay, --continue, a mesh). Links and other spellings are recognized.
/// Devices such as /dev/null are ignored.
std::optional<std::string> same_place(const Options& options);

/// Returns the path of a new file in the folder: stem, date and time, and a number if that name is taken.
std::string unused_name(const std::string& folder, const std::string& stem, const std::string& ending);

}  // namespace fracture::app
