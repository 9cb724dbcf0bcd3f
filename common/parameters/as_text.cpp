#include "common/parameters/as_text.hpp"

#include "common/parameters/assignments.hpp"

namespace fracture {
namespace {

bool is_plain_name(const std::string& name) {
  return !name.empty() && name.find(',') == std::string::npos && name.front() != ' ' &&
         name.front() != '\t' && name.back() != ' ' && name.back() != '\t';
}

}  // namespace

std::optional<std::string> as_text(const nlohmann::json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  if (!value.empty() && value.front().is_object()) return assignments_as_text(value);
  std::string text;
  for (const nlohmann::json& item : value) {
    if (item.is_string() && !is_plain_name(item.get_ref<const std::string&>())) return std::nullopt;
    const std::optional<std::string> part = as_text(item);
    if (!part) return std::nullopt;
    if (!text.empty()) text += item.is_array() ? ';' : ',';
    text += *part;
  }
  return text;
}

}  // namespace fracture
