// Draws many pictures in a single process, because creating a context and its shaders takes longer than
// drawing a small picture.
#pragma once

#include <functional>
#include <iosfwd>

#include "client/cli/picture_options.hpp"

namespace fracture::cli {

/// Reads lines until the end, each a JSON object with the options of a picture and "output", the PNG to write. Each
/// line is answered at once by a line {"output": …} (null if the line has none), with a "problem" (type and detail) if there is no picture.
/// An invalid line, or a file that cannot be drawn, does not end the process.
void draw_list(
    std::istream& in, std::ostream& out,
    const std::function<Expected<void>(const PictureOptions& options, const std::string& output)>& draw);

}  // namespace fracture::cli
