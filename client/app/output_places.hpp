// No file that the command line names is written over by another one of it.
#pragma once

#include <optional>
#include <string>

#include "client/app/options.hpp"

namespace fracture::app {

/// "--wav and --replay are both 'x'." where two of --record, --wav and --log are one place, or one is what is read (--replay,
/// a mesh), however it is spelt: links count, devices such as /dev/null do not.
std::optional<std::string> same_place(const Options& options);

}  // namespace fracture::app
