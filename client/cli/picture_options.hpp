// What one picture shows. The command line and sheet files come in as the same JSON object, so that names,
// ranges and errors exist once.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "client/render/fragment_views.hpp"
#include "client/render/renderer.hpp"

namespace fracture::cli {

struct PictureOptions {
  std::string file;  ///< GLB, or glTF with everything inside
  int width = 800, height = 600;
  int supersample = 1;  ///< 1 … 4: drawn that much larger and averaged
  render::CameraPlacement camera;
  render::ViewOptions view;
  render::RenderSettings settings;
  std::string frame = "view";  ///< what the camera is fitted to: "view" or "assembled"
};

/// One option of a picture: for --help, and for the check of values.
struct OptionSpec {
  const char* name;
  const char* type;  ///< as shown: "0 … 10", "x,y,z"
  const char* doc;
  void (*set)(PictureOptions& options,
              const nlohmann::json& value);  ///< throws std::invalid_argument with the range
};

std::span<const OptionSpec> option_specs();

/// Sets every member of the object. kBadOption names the key and what is legal; `where` stands in front.
Expected<void> set_options(PictureOptions& options, const nlohmann::json& object, const std::string& where);

}  // namespace fracture::cli
