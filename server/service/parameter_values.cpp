#include "server/service/parameter_values.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace fracture {
namespace {

/// JSON text must be UTF-8, and the canonical parameters are JSON: strict and lenient spelling differ else.
bool is_utf8(const std::string& text) {
  const nlohmann::json value(text);
  using Handler = nlohmann::json::error_handler_t;
  return value.dump(-1, ' ', false, Handler::ignore) == value.dump(-1, ' ', false, Handler::replace);
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
    return value.is_array() ? "an array" : "an object";  // dump() recurses: never on depth
  std::string s = value.is_string() ? value.get<std::string>() : value.dump();
  if (s.size() > 40) s = s.substr(0, 40) + "...";
  for (char& c : s)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f) c = '?';
  return s;
}

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

std::optional<double> to_number(const RawParameter& raw) {
  double number = 0;
  if (!raw.is_text) {
    if (!raw.value.is_number()) return std::nullopt;
    number = raw.value.get<double>();
  } else {
    const auto& text = raw.value.get_ref<const std::string&>();
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
  }
  return std::isfinite(number) ? std::optional(number == 0 ? 0.0 : number) : std::nullopt;
}

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

std::string shortest(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

std::optional<std::string> to_text(const RawParameter& raw) {
  if (!raw.value.is_string()) return std::nullopt;
  const auto& text = raw.value.get_ref<const std::string&>();
  const bool control =
      std::any_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
  return text.empty() || text.size() > 63 || control || !is_utf8(text) ? std::nullopt : std::optional(text);
}

}  // namespace fracture
