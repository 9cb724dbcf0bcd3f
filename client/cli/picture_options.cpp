#include "client/cli/picture_options.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace fracture::cli {
namespace {

using nlohmann::json;
using render::Colors;
using render::Ground;
using render::Highlight;
using render::View;

[[noreturn]] void refuse(const std::string& legal) { throw std::invalid_argument(legal); }

/// Sheets contain numbers; the command line contains text.
double number(const json& value, double low, double high) {
  std::ostringstream range;
  range << "a number from " << low << " to " << high;
  double x = 0;
  if (value.is_number()) {
    x = value.get<double>();
  } else if (value.is_string()) {
    const auto& text = value.get_ref<const std::string&>();
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
    if (error != std::errc() || end != text.data() + text.size()) refuse(range.str());
  } else {
    refuse(range.str());
  }
  if (!(x >= low && x <= high)) refuse(range.str());
  return x;
}

float real(const json& value, double low, double high) {
  return static_cast<float>(number(value, low, high));
}

int whole(const json& value, int low, int high) {
  const double x = number(value, low, high);
  if (x != std::floor(x))
    refuse("a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  return static_cast<int>(x);
}

bool yes(const json& value) {
  if (value.is_boolean()) return value.get<bool>();
  if (value == "true" || value == "false") return value == "true";
  refuse("true or false");
}

/// Reads [x, y, z] or "x,y,z".
glm::vec3 vector(const json& value) {
  constexpr double kFar = 1e6;
  std::vector<json> parts;
  if (value.is_array()) {
    parts.assign(value.begin(), value.end());
  } else if (value.is_string()) {
    std::istringstream text(value.get<std::string>());
    for (std::string part; std::getline(text, part, ',');) parts.emplace_back(part);
  }
  if (parts.size() != 3) refuse("three numbers x,y,z");
  return {real(parts[0], -kFar, kFar), real(parts[1], -kFar, kFar), real(parts[2], -kFar, kFar)};
}

template <class T, std::size_t N>
T choose(const json& value, const std::array<std::pair<const char*, T>, N>& known) {
  std::string names;
  for (const auto& [name, choice] : known) {
    if (value == name) return choice;
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  refuse("one of " + names);
}

constexpr std::array kViews = {std::pair{"assembled", View::kAssembled},
                               std::pair{"exploded", View::kExploded}, std::pair{"impact", View::kImpact}};
constexpr std::array kGrounds = {std::pair{"none", Ground::kNone}, std::pair{"plane", Ground::kPlane},
                                 std::pair{"grid", Ground::kGrid}};
constexpr std::array kTiers = {std::pair{"low", render::Tier::kLow}, std::pair{"high", render::Tier::kHigh}};
enum class ColorChoice { kMaterial, kFragment, kLevel, kInterior };
constexpr std::array kColors = {
    std::pair{"material", ColorChoice::kMaterial}, std::pair{"fragment", ColorChoice::kFragment},
    std::pair{"level", ColorChoice::kLevel}, std::pair{"interior", ColorChoice::kInterior}};

using P = PictureOptions;
using J = const json&;

constexpr OptionSpec kSpecs[] = {
    {"file", "FILE", "GLB to render",
     [](P& o, J v) {
       if (!v.is_string()) refuse("the name of a file");
       o.file = v.get<std::string>();
     }},
    {"size", "WIDTHxHEIGHT", "Picture size in pixels, 16 to 4096 per side",
     [](P& o, J v) {
       const char* legal = "WIDTHxHEIGHT with sides from 16 to 4096";
       if (!v.is_string()) refuse(legal);
       const auto& text = v.get_ref<const std::string&>();
       const auto cross = text.find('x');
       if (cross == std::string::npos) refuse(legal);
       try {
         o.width = whole(text.substr(0, cross), 16, 4096);
         o.height = whole(text.substr(cross + 1), 16, 4096);
       } catch (const std::invalid_argument&) {
         refuse(legal);
       }
     }},
    {"view", "VIEW", "Arrangement of the fragments: assembled, exploded, impact",
     [](P& o, J v) { o.view.view = choose(v, kViews); }},
    {"explode", "0 to 10", "How far fragments move from the centre; 1 doubles every distance",
     [](P& o, J v) { o.view.explode = real(v, 0, 10); }},
    {"colors", "COLORS", "Colours: material, fragment (by id), level (by group), interior (cut faces orange)",
     [](P& o, J v) {
       const ColorChoice choice = choose(v, kColors);
       o.view.colors = choice == ColorChoice::kFragment ? Colors::kFragment
                       : choice == ColorChoice::kLevel  ? Colors::kLevel
                                                        : Colors::kMaterial;
       o.settings.highlight = choice == ColorChoice::kInterior ? Highlight::kInterior : Highlight::kNone;
     }},
    {"level", "0 to 64", "Hierarchy level; 0 is the coarsest",
     [](P& o, J v) { o.view.level = whole(v, 0, 64); }},
    {"by-group", "", "Explode the level's groups instead of the fragments",
     [](P& o, J v) { o.view.by_group = yes(v); }},
    {"look", "LOOK",
     "One material for everything: glass, wood, concrete, stone, brick, ceramic, metal, ice, plaster, grey (the file's, without colours); none: the file's",
     [](P& o, J v) {
       const auto look = render::look_by_name(v.is_string() ? v.get<std::string>() : v.dump());
       if (!look) refuse(look.error().detail);
       o.settings.look = *look;
     }},
    {"grain", "x,y,z", "Grain direction for --look", [](P& o, J v) { o.settings.grain = vector(v); }},
    {"impact", "x,y,z", "Impact point in metres; default: the point at which the camera looks",
     [](P& o, J v) { o.view.impact_point = vector(v); }},
    {"impact-radius", "metres", "Fragments farther than this from the impact do not move",
     [](P& o, J v) { o.view.impact_radius = real(v, 0, 1e6); }},
    {"impact-direction", "x,y,z", "Direction of the impact; default: away from the camera",
     [](P& o, J v) { o.view.impact_direction = vector(v); }},
    {"impact-strength", "0 to 10",
     "Impact strength; 1 moves the nearest fragments by about the object's size",
     [](P& o, J v) { o.view.impact_strength = real(v, 0, 10); }},
    {"yaw", "-360 to 360", "Degrees around the object; 0 looks along -z",
     [](P& o, J v) { o.camera.yaw = real(v, -360, 360); }},
    {"pitch", "-89 to 89", "Degrees above the horizon", [](P& o, J v) { o.camera.pitch = real(v, -89, 89); }},
    {"field-of-view", "1 to 120", "Field of view of the shorter side in degrees",
     [](P& o, J v) { o.camera.field_of_view = real(v, 1, 120); }},
    {"margin", "0.1 to 10", "Space around the object; at 1, its bounding sphere fills the picture",
     [](P& o, J v) { o.camera.margin = real(v, 0.1, 10); }},
    {"target", "x,y,z", "Point in metres at which the camera looks; default: the middle of the object",
     [](P& o, J v) { o.camera.target = vector(v); }},
    {"orthographic", "", "Draw without perspective", [](P& o, J v) { o.camera.orthographic = yes(v); }},
    {"frame", "FRAME",
     "Arrangement that the camera frames: view, or assembled (fragments may then leave the picture)",
     [](P& o, J v) {
       if (v != "view" && v != "assembled") refuse("one of view, assembled");
       o.frame = v.get<std::string>();
     }},
    {"ground", "GROUND", "Ground below the object: none, plane, grid",
     [](P& o, J v) { o.settings.ground = choose(v, kGrounds); }},
    {"exposure", "0.01 to 100", "Factor for all light",
     [](P& o, J v) { o.settings.lighting.exposure = real(v, 0.01, 100); }},
    {"sky-shadows", "0 to 64", "Number of sky directions that cast shadows",
     [](P& o, J v) { o.settings.lighting.sky_shadows = whole(v, 0, render::kMaxSkyDirections); }},
    {"picture", "PICTURE", "Quality: low (without a graphics card), high (with one)",
     [](P& o, J v) { o.settings.tier = choose(v, kTiers); }},
    {"supersample", "1 to 4", "Draw the picture this many times larger, then scale it down",
     [](P& o, J v) { o.supersample = whole(v, 1, 4); }},
};

}  // namespace

std::span<const OptionSpec> option_specs() { return kSpecs; }

Expected<void> set_options(PictureOptions& options, const json& object, const std::string& where) {
  if (!object.is_object()) return fail(ErrorCode::kBadParameter, where + " must be a JSON object.");
  for (const auto& [key, value] : object.items()) {
    const OptionSpec* found = nullptr;
    for (const OptionSpec& spec : kSpecs)
      if (key == spec.name) found = &spec;
    if (found == nullptr)
      return fail(ErrorCode::kBadParameter, where + ": there is no option '" + key + "'.");
    try {
      found->set(options, value);
    } catch (const std::invalid_argument& legal) {
      return fail(ErrorCode::kBadParameter,
                  where + ": '" + key + "' must be " + legal.what() + "; it was " + value.dump() + ".");
    }
  }
  return {};
}

}  // namespace fracture::cli
