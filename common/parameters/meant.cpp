// Finds the parameter or choice that a wrong name or value probably means.
#include <algorithm>
#include <utility>

#include "common/base/nearest_name.hpp"
#include "common/parameters/groups.hpp"

namespace fracture {
namespace {

/// Other words for the choices of a parameter, separated by ", ", in lower case.
struct OtherWords {
  std::string_view parameter, choice, words;
};

constexpr OtherWords kOtherWords[] = {
    {"material", "stone", "rock, granite, marble, basalt, slate"},
    {"material", "wood", "timber, oak, pine, plank, tree"},
    {"material", "metal", "steel, aluminium, aluminum, copper"},
    {"material", "cast_iron", "iron"},
    {"material", "ceramic", "porcelain, china, pottery, tile"},
    {"material", "terracotta", "clay, earthenware, pot"},
    {"material", "brick", "bricks, masonry"},
    {"material", "plaster", "gypsum, stucco, drywall"},
    {"material", "concrete", "cement, asphalt"},
    {"material", "glass", "window, pane, mirror"},
    {"material", "ice", "snow, frost"},
    {"material", "crystal", "gem, quartz, diamond"},
    {"pattern", "uniform", "voronoi, random, even, default"},
    {"pattern", "impact", "explosion, hit, bullet"},
    {"pattern", "radial", "web, spokes, rings"},
    {"pattern", "grid", "boxes, cubes, voxels"},
    {"pattern", "brick", "bricks, masonry"},
    {"pattern", "slice", "slices, planes, cut"},
    {"pattern", "clustered", "cluster, clusters"},
    {"pattern", "points", "custom, sites"},
    {"unit", "m", "metre, meter, metres, meters"},
    {"unit", "cm", "centimetre, centimeter, centimetres, centimeters"},
    {"unit", "mm", "millimetre, millimeter, millimetres, millimeters"},
    {"unit", "inch", "inches, in"},
    {"physics", "omi", "godot"},
    {"physics", "none", "off, false, no"},
    {"ue_collision", "ucx", "unreal, ue, true, yes"},
    {"repair", "fill", "fix, close, true, yes"},
    {"repair", "strict", "none, off, false, no"},
    {"intact", "true", "yes, on, 1"},
    {"intact", "false", "no, off, 0"},
};

/// Returns the word in lower case, with dashes and underscores as spaces.
std::string plain(std::string_view word) {
  std::string text(word);
  for (char& c : text) {
    if (c == '_' || c == '-') c = ' ';
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + ('a' - 'A'));
  }
  return text;
}

std::vector<std::string> split_words(std::string_view words) {
  std::vector<std::string> list;
  while (!words.empty()) {
    const std::size_t comma = words.find(", ");
    list.emplace_back(words.substr(0, comma));
    words = comma == std::string_view::npos ? std::string_view() : words.substr(comma + 2);
  }
  return list;
}

bool lists(std::string_view words, const std::string& wanted) {
  const std::vector<std::string> list = split_words(words);
  return std::any_of(list.begin(), list.end(),
                     [&](const std::string& word) { return plain(word) == wanted; });
}

}  // namespace

std::vector<std::string> synonyms_of(std::string_view parameter) {
  for (const ParameterGroup& group : parameter_groups())
    for (const GroupedParameter& row : group.parameters)
      if (row.name == parameter) return split_words(row.synonyms);
  return {};
}

nlohmann::json parameter_groups_json() {
  nlohmann::json groups = nlohmann::json::array();
  for (const ParameterGroup& group : parameter_groups()) {
    nlohmann::json names = nlohmann::json::array();
    for (const GroupedParameter& row : group.parameters) names.push_back(row.name);
    groups.push_back(
        {{"title", group.title}, {"description", group.words}, {"parameters", std::move(names)}});
  }
  return groups;
}

std::optional<std::string> parameter_meant_by(std::string_view name, std::span<const std::string> known) {
  const std::string wanted = plain(name);
  for (const ParameterGroup& group : parameter_groups())
    for (const GroupedParameter& row : group.parameters)
      if (lists(row.synonyms, wanted) && std::find(known.begin(), known.end(), row.name) != known.end())
        return std::string(row.name);
  return nearest_name(name, known);
}

std::optional<std::string> choice_meant_by(const ParameterSpec& spec, std::string_view value) {
  const std::string wanted = plain(value);
  for (const std::string& choice : spec.choices)
    if (plain(choice) == wanted) return choice;
  for (const OtherWords& row : kOtherWords)
    if (row.parameter == spec.name && lists(row.words, wanted)) return std::string(row.choice);
  return nearest_name(value, spec.choices);
}

}  // namespace fracture
