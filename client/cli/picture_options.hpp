// The content of one picture. The command line and sheet files arrive as the same JSON object, so names,
// ranges and errors are defined once.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "client/render/fragment_views.hpp"
#include "client/render/renderer.hpp"

namespace fracture::cli {

struct PictureOptions {
  std::string file;  ///< GLB, or glTF with all data embedded
  int width = 800, height = 600;
  int supersample = 1;  ///< 1 … 4: drawn this many times larger, then averaged
  render::CameraPlacement camera;
  render::ViewOptions view;
  render::RenderSettings settings;
  std::string frame = "view";  ///< what the camera is fitted to: "view" or "assembled"
};

/// One option of a picture, for --help and for checking values.
struct OptionSpec {
  const char* name;
  const char* type;  ///< as shown: "0 … 10", "x,y,z"
  const char* doc;
  void (*set)(PictureOptions& options,
              const nlohmann::json& value);  ///< throws std::invalid_argument, which states the range
};

std::span<const OptionSpec> option_specs();

/// Sets every member of the object. kBadParameter names the key and the legal values; the message begins with
/// `where`.
Expected<void> set_options(PictureOptions& options, const nlohmann::json& object, const std::string& where);

}  // namespace fracture::cli
