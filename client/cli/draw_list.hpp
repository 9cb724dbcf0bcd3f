// Draws many pictures in a single process, because creating a context and its shaders takes longer than
// drawing a small picture.
#pragma once

#include <functional>
#include <iosfwd>

#include "client/cli/picture_options.hpp"

namespace fracture::cli {

/// Reads lines until the end. Each is a JSON object with the options of a picture and "output", the PNG to
/// write. Writes one line {"output": …} for each picture as soon as it is drawn. "output" is null if the
/// input line lacks it. If the picture cannot be drawn, the line has a "problem" with type and detail. An
/// invalid line, or a file that cannot be drawn, does not end the process.
void draw_list(
    std::istream& in, std::ostream& out,
    const std::function<Expected<void>(const PictureOptions& options, const std::string& output)>& draw);

}  // namespace fracture::cli
