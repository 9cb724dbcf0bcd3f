// Contact sheets: a table of pictures with labels, described by a JSON file
//
//   {"title": "…", "options": {…},
//    "columns": [{"label": "intact", "options": {…}}, …],
//    "rows":    [{"label": "glass",  "options": {…}}, …],
//    "cells":   [[{…}, …], …]}
//
// A cell's options are those of the sheet, then of its row, then of its column, then its own (all optional).
// Files are named relative to the sheet's folder. The size of a picture is the sheet's.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "client/cli/picture_options.hpp"

namespace fracture::cli {

struct Sheet {
  std::string title;
  std::vector<std::string> columns, rows;  ///< labels
  std::vector<PictureOptions> cells;       ///< row by row, all of the same size
};

/// kFile, kBadOption with the place in the file.
Expected<Sheet> read_sheet(const std::string& path);

/// Draws every cell and puts them together. Errors of `draw` end it.
Expected<render::Picture> compose_sheet(
    const Sheet& sheet, const std::function<Expected<render::Picture>(const PictureOptions&)>& draw);

}  // namespace fracture::cli
