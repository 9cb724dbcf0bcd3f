// Many pictures by one process, for whoever has thousands to draw: a context and its shaders
// take longer to make than a small picture to draw.
#pragma once

#include <functional>
#include <iosfwd>

#include "client/cli/picture_options.hpp"

namespace fracture::cli {

/// Reads lines until there are no more, each a JSON object: the options of a picture and "output", the PNG to write. Every
/// line is answered by one, at once: {"output": …} (null where the line names none), and where there is no picture "problem" with type and detail. A line
/// that is wrong, or a file that cannot be drawn, ends nothing.
void draw_list(
    std::istream& in, std::ostream& out,
    const std::function<Expected<void>(const PictureOptions& options, const std::string& output)>& draw);

}  // namespace fracture::cli
