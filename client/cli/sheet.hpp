// Contact sheets: a table of pictures with labels, described by a JSON file
//
//   {"title": "…", "options": {…},
//    "columns": [{"label": "intact", "options": {…}}, …],
//    "rows":    [{"label": "glass",  "options": {…}}, …],
//    "cells":   [[{…}, …], …]}
//
// A cell combines the options of the sheet, its row, its column and itself, in this order (all are optional).
// File names are relative to the sheet's folder. The picture size is the same for the whole sheet.
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

/// Fails with kFileAccess, or with kBadParameter and the location in the file.
Expected<Sheet> read_sheet(const std::string& path);

/// Draws every cell and combines the pictures. Stops at the first error of `draw`.
Expected<render::Picture> compose_sheet(
    const Sheet& sheet, const std::function<Expected<render::Picture>(const PictureOptions&)>& draw);

}  // namespace fracture::cli
