#include "common/parameters/values.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <type_traits>
#include <utility>

#include "common/base/utf8.hpp"
#include "common/base/words.hpp"
#include "common/parameters/assignments.hpp"
#include "common/parameters/groups.hpp"

namespace fracture {
namespace {

bool is_color(const std::string& text) {
  const auto is_digit = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
  };
  return text.size() == 7 && text[0] == '#' && std::all_of(text.begin() + 1, text.end(), is_digit);
}

// The functions below return an empty value if the type is wrong.

std::optional<std::uint64_t> to_integer(const RawParameter& raw) {
  if (!raw.is_text) {
    const bool whole = raw.value.is_number_unsigned() ||
                       (raw.value.is_number_integer() && raw.value.get<std::int64_t>() >= 0);
    return whole ? std::optional(raw.value.get<std::uint64_t>()) : std::nullopt;
  }
  const auto& text = raw.value.get_ref<const std::string&>();
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return number;
}

/// Returns the names sorted, without duplicates; nothing if an entry is empty, not UTF-8 or not text.
std::optional<std::vector<std::string>> to_names(const RawParameter& raw) {
  std::vector<std::string> names;
  if (raw.value.is_string()) {
    std::string_view text = raw.value.get_ref<const std::string&>();
    for (;;) {
      const std::size_t comma = text.find(',');
      names.emplace_back(text.substr(0, comma));
      if (comma == std::string_view::npos) break;
      text.remove_prefix(comma + 1);
    }
  } else if (raw.value.is_array() && !raw.value.empty()) {
    for (const auto& entry : raw.value) {
      if (!entry.is_string()) return std::nullopt;
      names.push_back(entry.get<std::string>());
    }
  } else {
    return std::nullopt;
  }
  for (const std::string& name : names)
    if (name.empty() || !is_utf8(name)) return std::nullopt;
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

/// Returns UTF-8 text without control characters.
std::optional<std::string> to_text(const ParameterSpec& spec, const RawParameter& raw) {
  if (!raw.value.is_string()) return std::nullopt;
  const auto& text = raw.value.get_ref<const std::string&>();
  const bool control =
      std::any_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
  return text.empty() || text.size() > spec.longest_text() || control || !is_utf8(text) ? std::nullopt
                                                                                        : std::optional(text);
}

/// Returns the index of the choice.
std::optional<std::uint64_t> to_choice(const ParameterSpec& spec, const RawParameter& raw) {
  std::string choice = raw.value.is_string()    ? raw.value.get<std::string>()
                       : raw.value.is_boolean() ? raw.value.dump()
                                                : std::string();
  if (spec.name == "format")  // extensions can be upper case: part.STL
    for (char& c : choice)
      if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + ('a' - 'A'));
  const auto at = std::find(spec.choices.begin(), spec.choices.end(), choice);
  if (at == spec.choices.end()) return std::nullopt;
  return static_cast<std::uint64_t>(at - spec.choices.begin());
}

/// Returns the entries of a text a,b,c or of a JSON array; nothing if there are none or too many.
std::optional<std::vector<RawParameter>> list_items(const RawParameter& raw) {
  std::vector<RawParameter> items;
  if (raw.is_text) {
    std::string_view text = raw.value.get_ref<const std::string&>();
    for (std::size_t end = 0; end != std::string_view::npos && items.size() <= kMaxIntegers;) {
      end = text.find(',');
      items.push_back({raw.name, std::string(text.substr(0, end)), true});
      if (end != std::string_view::npos) text.remove_prefix(end + 1);
    }
  } else if (raw.value.is_array() && raw.value.size() <= kMaxIntegers) {
    for (const nlohmann::json& item : raw.value) items.push_back({raw.name, item, false});
  } else if (raw.value.is_number()) {
    items.push_back(raw);
  }
  if (items.empty() || items.size() > kMaxIntegers) return std::nullopt;
  return items;
}

/// Returns whole numbers, each from min to max.
std::optional<std::vector<std::uint64_t>> to_integers(const ParameterSpec& spec, const RawParameter& raw) {
  const auto items = list_items(raw);
  if (!items) return std::nullopt;
  std::vector<std::uint64_t> numbers;
  for (const RawParameter& item : *items) {
    const std::optional<std::uint64_t> number = to_integer(item);
    if (!number || *number < spec.min || *number > spec.max) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

/// Returns numbers, each from low to high.
std::optional<std::vector<double>> to_numbers(const ParameterSpec& spec, const RawParameter& raw) {
  const auto items = list_items(raw);
  if (!items) return std::nullopt;
  std::vector<double> numbers;
  for (const RawParameter& item : *items) {
    const std::optional<double> number = to_number(item.value, item.is_text);
    if (!number || !(*number >= spec.low && *number <= spec.high)) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

/// Empty if the value has the wrong type or is out of range.
std::optional<ParameterValue> to_scalar(const ParameterSpec& spec, const RawParameter& raw) {
  const auto value = [](auto&& found) {
    return found ? std::optional<ParameterValue>(std::move(*found)) : std::nullopt;
  };
  switch (spec.type) {
    case ParameterSpec::Type::kInteger: {
      const auto number = to_integer(raw);
      return number && *number >= spec.min && *number <= spec.max ? value(number) : std::nullopt;
    }
    case ParameterSpec::Type::kIntegers:
      return value(to_integers(spec, raw));
    case ParameterSpec::Type::kNumber: {
      const auto number = to_number(raw.value, raw.is_text);
      return number && *number >= spec.low && *number <= spec.high ? value(number) : std::nullopt;
    }
    case ParameterSpec::Type::kNumbers:
      return value(to_numbers(spec, raw));
    case ParameterSpec::Type::kNames:
      return value(to_names(raw));
    case ParameterSpec::Type::kText:
      return value(to_text(spec, raw));
    case ParameterSpec::Type::kColor:
      if (raw.value.is_string() && is_color(raw.value.get_ref<const std::string&>()))
        return raw.value.get<std::string>();
      return std::nullopt;
    default:
      return value(to_choice(spec, raw));
  }
}

bool is_vector(ParameterSpec::Type type) {
  return type == ParameterSpec::Type::kVector || type == ParameterSpec::Type::kDirection ||
         type == ParameterSpec::Type::kVectors || type == ParameterSpec::Type::kMatrix;
}

}  // namespace

namespace {

/// Groups the digits of whole limits, and writes other limits with as few digits as possible.
std::string limit_in_words(double limit) {
  const double size = std::fabs(limit);
  if (!(size >= 1000 && size < 1e9) || size != std::floor(size)) return shortest(limit);
  return (limit < 0 ? "-" : "") + grouped(static_cast<std::uint64_t>(size));
}

/// Returns all choices, or the first ones and where the others are listed.
std::string choices_in_words(const std::vector<std::string>& choices) {
  constexpr std::size_t kMostListed = 20, kShown = 6;
  if (choices.size() <= kMostListed) return join(choices);
  std::string first;
  for (std::size_t k = 0; k < kShown; ++k) first += choices[k] + ", ";
  return first + "or another of the " + grouped(choices.size()) +
         " values that GET /limits and `--help` list";
}

}  // namespace

std::string join(const std::vector<std::string>& words) {
  std::string s;
  for (std::size_t i = 0; i < words.size(); ++i)
    s += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return s;
}

std::string shown(const nlohmann::json& value) {
  if (value.is_structured())
    return value.is_array() ? "an array"
                            : "an object";  // dump() recurses, so it is not called on nested values
  std::string s = value.is_string() ? value.get<std::string>() : value.dump();
  if (s.size() > 40) s = s.substr(0, 40) + "...";
  for (char& c : s)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f) c = '?';
  return s;
}

std::string shortest(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

std::optional<double> to_number(const nlohmann::json& value, bool is_text) {
  double number = 0;
  if (!is_text) {
    if (!value.is_number()) return std::nullopt;
    number = value.get<double>();
  } else {
    const auto& text = value.get_ref<const std::string&>();
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
  }
  return std::isfinite(number) ? std::optional(number == 0 ? 0.0 : number) : std::nullopt;
}

std::string expectation(const ParameterSpec& spec) {
  const std::string range = "from " + limit_in_words(spec.low) + " to " + limit_in_words(spec.high);
  switch (spec.type) {
    case ParameterSpec::Type::kInteger:
      return "a whole number from " + grouped(spec.min) + " to " + grouped(spec.max);
    case ParameterSpec::Type::kIntegers:
      return "whole numbers from " + grouped(spec.min) + " to " + grouped(spec.max) +
             ", as text a,b,c or as JSON [a, b, c]";
    case ParameterSpec::Type::kNumber:
      return "a number " + range;
    case ParameterSpec::Type::kNumbers:
      return "numbers " + range + ", as text a,b,c or as JSON [a, b, c]";
    case ParameterSpec::Type::kNames:
      return "non-empty names or indices in UTF-8, separated by commas";
    case ParameterSpec::Type::kText:
      return "1 to " + std::to_string(spec.longest_text()) + " bytes of text";
    case ParameterSpec::Type::kColor:
      return "an sRGB colour as #rrggbb";
    case ParameterSpec::Type::kVector:
      return "three numbers " + range + ", as text x,y,z or as JSON [x, y, z]";
    case ParameterSpec::Type::kDirection:
      return "three numbers " + range + ", not all zero, as text x,y,z or as JSON [x, y, z]";
    case ParameterSpec::Type::kVectors:
      return grouped(spec.min) + (spec.min == spec.max ? "" : " to " + grouped(spec.max)) +
             " vectors of three numbers " + range + ", as text x,y,z;x,y,z or as JSON [[x, y, z], ...]";
    case ParameterSpec::Type::kMatrix:
      return "three rows of three numbers " + range +
             ", as text a,b,c;d,e,f;g,h,i or as JSON [[a, b, c], ...]";
    case ParameterSpec::Type::kAssignments:
      return "1 to " + std::to_string(kMostAssignments) +
             " entries, as text selector:material;selector:material or as JSON [{\"node\": ..., \"material\": ...}, ...]";
    case ParameterSpec::Type::kChoice:
      break;
  }
  return join(spec.choices);
}

Expected<ParameterValue> to_value(const ParameterSpec& spec, const RawParameter& raw) {
  const auto wrong = [&](const std::string& must) {
    const std::string given = shown(raw.value);
    const std::optional<std::string> meant =
        spec.type == ParameterSpec::Type::kChoice ? choice_meant_by(spec, given) : std::nullopt;
    return fail(spec.name == "format" ? ErrorCode::kUnknownFormat : ErrorCode::kBadParameter,
                "'" + spec.name + "' must " + must + "; it was '" + given + "'." +
                    (meant ? " Did you mean '" + *meant + "'?" : std::string()));
  };
  Expected<ParameterValue> value;
  if (spec.type == ParameterSpec::Type::kAssignments) return to_assignments(raw);
  if (is_vector(spec.type))
    value = to_vectors(spec, raw);
  else if (std::optional<ParameterValue> scalar = to_scalar(spec, raw))
    value = std::move(*scalar);
  else
    return wrong("be " + (spec.type == ParameterSpec::Type::kChoice ? choices_in_words(spec.choices)
                                                                    : expectation(spec)));
  if (!value) return value;
  // A direction must have a length by which it can be divided.
  if (spec.type == ParameterSpec::Type::kDirection && !(length(std::get<Vec3d>(*value)) > 1e-9))
    return wrong("be " + expectation(spec));
  if (spec.check)
    if (const std::optional<std::string> must = spec.check(*value)) return wrong(*must);
  return value;
}

nlohmann::json to_json(const ParameterSpec& spec, const ParameterValue& value) {
  const auto of_vector = [](const Vec3d& v) { return nlohmann::json{v.x, v.y, v.z}; };
  if (spec.type == ParameterSpec::Type::kChoice) return spec.choices.at(std::get<std::uint64_t>(value));
  if (const auto* vector = std::get_if<Vec3d>(&value)) return of_vector(*vector);
  nlohmann::json list = nlohmann::json::array();
  if (const auto* vectors = std::get_if<std::vector<Vec3d>>(&value)) {
    for (const Vec3d& v : *vectors) list.push_back(of_vector(v));
    return list;
  }
  if (const auto* matrix = std::get_if<Matrix3>(&value)) {
    for (const Vec3d& row : matrix->rows) list.push_back(of_vector(row));
    return list;
  }
  return std::visit(
      [&](const auto& plain) -> nlohmann::json {
        if constexpr (std::is_constructible_v<nlohmann::json, decltype(plain)>)
          return plain;
        else
          return list;
      },
      value);
}

}  // namespace fracture
