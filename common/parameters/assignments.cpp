#include "common/parameters/assignments.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string>
#include <utility>

#include "common/base/json_reader.hpp"
#include "common/base/json_text.hpp"
#include "common/parameters/parameter_object.hpp"
#include "common/parameters/rows.hpp"
#include "common/parameters/values.hpp"

namespace fracture {
namespace {

using nlohmann::json;

constexpr std::string_view kNode = "node", kSlot = "slot", kPart = "part";

tl::unexpected<Error> wrong(const std::string& must, std::string pointer = {}) {
  return fail(ErrorCode::kBadParameter, "'assign' must " + must + ".", std::move(pointer));
}

std::string entry_words(std::size_t index) {
  return "in entry " + std::to_string(index + 1) + " of 'assign'";
}

/// Reads the names of a selector: text, or a list of texts.
Expected<std::vector<std::string>> names_of(std::string_view kind, const json& value, std::size_t entry) {
  const std::string pointer = "/" + std::to_string(entry) + "/" + std::string(kind);
  const json list = value.is_array() ? value : json::array({value});
  std::vector<std::string> names;
  for (const json& name : list) {
    if (!name.is_string()) break;
    names.push_back(name.get<std::string>());
    if (names.back().empty() || names.back().size() > kMostBytesOfName) break;
  }
  if (!list.empty() && list.size() <= kMostNamesOfSelector && names.size() == list.size() &&
      !names.back().empty() && names.back().size() <= kMostBytesOfName)
    return names;
  return fail(ErrorCode::kBadParameter,
              "'" + std::string(kind) + "' " + entry_words(entry) +
                  " must be a name or a pattern, or a list of 1 to " + std::to_string(kMostNamesOfSelector) +
                  " of them with 1 to " + std::to_string(kMostBytesOfName) + " bytes each.",
              pointer);
}

Expected<std::vector<std::uint32_t>> parts_of(const json& value, std::size_t entry) {
  const json list = value.is_array() ? value : json::array({value});
  std::vector<std::uint32_t> parts;
  for (const json& part : list)
    if (part.is_number_integer() && part >= 0 && part < kNoIndex) parts.push_back(part.get<std::uint32_t>());
  if (!list.empty() && list.size() <= kMostNamesOfSelector && parts.size() == list.size()) return parts;
  return fail(ErrorCode::kBadParameter,
              "'part' " + entry_words(entry) + " must be the number of a part, from 0, or a list of 1 to " +
                  std::to_string(kMostNamesOfSelector) + " numbers.",
              "/" + std::to_string(entry) + "/part");
}

Expected<RawAssignment> entry_of(const json& value, std::size_t index) {
  const std::string at = "/" + std::to_string(index);
  if (!value.is_object())
    return wrong("contain objects such as {\"node\": \"Wall_*\", \"material\": \"brick\"}; entry " +
                     std::to_string(index + 1) + " is " + shown(value),
                 at);
  RawAssignment entry;
  for (const auto& [name, member] : value.items()) {
    if (name == kNode || name == kSlot) {
      auto names = names_of(name, member, index);
      if (!names) return tl::unexpected(std::move(names.error()));
      (name == kNode ? entry.selector.nodes : entry.selector.slots) = std::move(*names);
    } else if (name == kPart) {
      auto parts = parts_of(member, index);
      if (!parts) return tl::unexpected(std::move(parts.error()));
      entry.selector.parts = std::move(*parts);
    } else {
      entry.parameters.push_back({name, member, false});
    }
  }
  if (entry.selector.empty())
    return wrong("say which parts each entry is for: entry " + std::to_string(index + 1) +
                     " has no 'node', 'slot' or 'part'",
                 at);
  if (entry.parameters.empty())
    return wrong(
        "give each entry a 'material' or other parameters; entry " + std::to_string(index + 1) + " has none",
        at);
  return entry;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = std::min(text.find_first_not_of(" \t\n"), text.size());
  return text.substr(begin, text.find_last_not_of(" \t\n") + 1 - begin);
}

/// Reads one `selector:material`.
Expected<json> entry_of_text(std::string_view text, std::size_t index) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0 || colon + 1 == text.size())
    return wrong(
        "be selector:material;selector:material, such as Wall_*:brick;slot=Glass:glass;part=3:wood, or a JSON list; entry " +
        std::to_string(index + 1) + " was '" + shown(json(std::string(text))) + "'");
  std::string_view selector = text.substr(0, colon);
  std::string_view kind = kNode;
  for (const std::string_view known : {kNode, kSlot, kPart})
    if (selector.starts_with(known) && selector.substr(known.size()).starts_with('=')) {
      kind = known;
      selector.remove_prefix(known.size() + 1);
      break;
    }
  json entry = {{"material", std::string(text.substr(colon + 1))}};
  if (kind == kPart) {
    std::uint32_t part = 0;
    const auto [end, error] = std::from_chars(selector.data(), selector.data() + selector.size(), part);
    if (error != std::errc{} || end != selector.data() + selector.size())
      return wrong("give the number of a part after 'part='; entry " + std::to_string(index + 1) + " had '" +
                   shown(json(std::string(selector))) + "'");
    entry[std::string(kind)] = part;
  } else {
    entry[std::string(kind)] = std::string(selector);
  }
  return entry;
}

Expected<json> list_of_text(std::string_view text) {
  if (trimmed(text).starts_with('[')) {
    auto read = read_json(text, {.depth = kParameterDepth, .bytes = kOfRequest.held});
    if (!read)
      return wrong("be selector:material;selector:material or a JSON list; as JSON, it " +
                   to_text(read.error()));
    return std::move(read->value);
  }
  json list = json::array();
  while (true) {
    const std::size_t end = text.find(';');
    if (const std::string_view one = trimmed(text.substr(0, end)); !one.empty()) {
      auto entry = entry_of_text(one, list.size());
      if (!entry) return entry;
      list.push_back(std::move(*entry));
    }
    if (end == std::string_view::npos) return list;
    text.remove_prefix(end + 1);
  }
}

template <class T>
json one_or_list(const std::vector<T>& values) {
  return values.size() == 1 ? json(values.front()) : json(values);
}

/// Names of the parameters of patterns, which an entry may have.
const std::vector<std::string>& pattern_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const ParameterSpec& row : pattern_parameter_rows(1)) list.push_back(row.name);
    return list;
  }();
  return names;
}

constexpr std::array<std::string_view, 31> kAssignable{"material",
                                                       "pattern",
                                                       "lloyd",
                                                       "density_from",
                                                       "stretch",
                                                       "grain",
                                                       "grain_of",
                                                       "stretch_matrix",
                                                       "cells_per_fragment",
                                                       "size_spread",
                                                       "rough_amplitude",
                                                       "rough_frequency",
                                                       "rough_octaves",
                                                       "shell",
                                                       "shell_fraction",
                                                       "shell_ball",
                                                       "density",
                                                       "friction",
                                                       "restitution",
                                                       "bond_strength",
                                                       "exterior",
                                                       "interior",
                                                       "interior_material",
                                                       "interior_name",
                                                       "interior_color",
                                                       "interior_mix",
                                                       "interior_shade",
                                                       "interior_opacity",
                                                       "interior_crushed",
                                                       "interior_roughness",
                                                       "interior_metallic"};

/// Canonical form of an entry.
json canonical_entry(const Assignment& assignment) {
  static const std::vector<ParameterSpec> rows = parameter_rows(1, FormatSet());
  json entry = to_json(assignment.selector);
  for (const ParameterSpec& row : rows) {
    if (std::find(assignment.given.begin(), assignment.given.end(), row.name) == assignment.given.end() ||
        !belongs(row, assignment.parameters->fracture.pattern))
      continue;
    if (json value = row.get(*assignment.parameters, row); !value.is_null())
      entry[row.name] = std::move(value);
  }
  return entry;
}

}  // namespace

ParameterSpec assign_row() {
  ParameterSpec spec{
      .name = "assign",
      .type = Type::kAssignments,
      .doc =
          "Materials for individual parts of the mesh. Each entry has a selector, and a `material` or other parameters "
          "of materials and patterns. Selectors: `node` (with all nodes below it), `slot` (the material on most of a "
          "part's surface) and `part` (a number). The first entry that matches a part applies. The `material` of the "
          "request does not apply to an entry without `material`.",
      .decides = Decides::kSites};
  spec.set = [](RequestParameters&, const ParameterSpec&, const ParameterValue&) {
  };  // ParameterTable::parse() does it
  spec.get = [](const RequestParameters& r, const ParameterSpec&) {
    json list;
    for (const Assignment& assignment : r.assign) list.push_back(canonical_entry(assignment));
    return list;
  };
  return spec;
}

Expected<std::vector<RawAssignment>> to_assignments(const RawParameter& raw) {
  json list = raw.value;
  if (raw.value.is_string()) {
    auto read = list_of_text(raw.value.get_ref<const std::string&>());
    if (!read) return tl::unexpected(std::move(read.error()));
    list = std::move(*read);
  }
  if (!list.is_array())
    return wrong("be a list of entries such as [{\"node\": \"Wall_*\", \"material\": \"brick\"}]; it was " +
                 shown(list));
  if (list.empty() || list.size() > kMostAssignments)
    return wrong("have 1 to " + std::to_string(kMostAssignments) + " entries; it had " +
                 std::to_string(list.size()));
  std::vector<RawAssignment> entries;
  for (const json& value : list) {
    auto entry = entry_of(value, entries.size());
    if (!entry) return tl::unexpected(std::move(entry.error()));
    entries.push_back(std::move(*entry));
  }
  return entries;
}

bool is_assignable(std::string_view name) {
  const std::vector<std::string>& of_patterns = pattern_names();
  return std::find(kAssignable.begin(), kAssignable.end(), name) != kAssignable.end() ||
         std::find(of_patterns.begin(), of_patterns.end(), name) != of_patterns.end();
}

bool is_inherited(std::string_view name) {
  return !is_assignable(name) || name == "impacts" || name == "exterior" || name == "interior";
}

json to_json(const PartSelector& selector) {
  json members = json::object();
  if (!selector.nodes.empty()) members["node"] = one_or_list(selector.nodes);
  if (!selector.slots.empty()) members["slot"] = one_or_list(selector.slots);
  if (!selector.parts.empty()) members["part"] = one_or_list(selector.parts);
  return members;
}

json walls_as_assignments(const HollowOptions& hollow) {
  json list;
  for (const PartWalls& walls : hollow.by_part) {
    json entry = to_json(walls.selector);
    if (walls.thickness > 0 || !(walls.fraction > 0)) entry["shell"] = walls.thickness;
    if (walls.fraction > 0) entry["shell_fraction"] = walls.fraction;
    if (walls.least_ball > 0) entry["shell_ball"] = walls.least_ball;
    list.push_back(std::move(entry));
  }
  return list;
}

std::string assignments_as_text(const json& entries) {
  std::string text;
  for (const json& entry : entries) {
    const bool is_simple = entry.is_object() && entry.size() == 2 && entry.contains("material");
    std::string one;
    for (const std::string_view kind : {kNode, kSlot, kPart}) {
      const auto at = is_simple ? entry.find(std::string(kind)) : entry.end();
      if (at == entry.end() || at->is_array()) continue;
      const std::string name = at->is_string() ? at->get<std::string>() : at->dump();
      if (name.find(';') == std::string::npos && trimmed(name) == name && !name.starts_with('['))
        one = (kind == kNode && name.find('=') == std::string::npos ? "" : std::string(kind) + "=") + name;
    }
    if (one.empty()) return json_text(entries);
    text += (text.empty() ? "" : ";") + one + ":" + entry["material"].get<std::string>();
  }
  return text;
}

}  // namespace fracture
