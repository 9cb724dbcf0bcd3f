#include "common/gltf/json_text.hpp"

namespace fracture {

JsonText& JsonText::value(std::string_view text) {
  static constexpr char kHex[] = "0123456789abcdef";
  separate();
  text_ += '"';
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      text_ += '\\';
      text_ += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      text_ += "\\u00";
      text_ += kHex[c >> 4];
      text_ += kHex[c & 15];
    } else {
      text_ += c;
    }
  }
  text_ += '"';
  comma_ = true;
  return *this;
}

JsonText& JsonText::value(const nlohmann::json& document) {
  switch (document.type()) {
    case nlohmann::json::value_t::object:
      begin_object();
      for (const auto& [name, child] : document.items()) {
        value(std::string_view(name));  // keys of foreign documents need escaping
        text_ += ':';
        comma_ = false;
        value(child);
      }
      return end_object();
    case nlohmann::json::value_t::array:
      begin_array();
      for (const auto& child : document) value(child);
      return end_array();
    case nlohmann::json::value_t::string:
      return value(std::string_view(document.get_ref<const std::string&>()));
    case nlohmann::json::value_t::boolean:
      return value(document.get<bool>());
    case nlohmann::json::value_t::number_integer:
      return value(document.get<std::int64_t>());
    case nlohmann::json::value_t::number_unsigned:
      return value(document.get<std::uint64_t>());
    case nlohmann::json::value_t::number_float:
      return value(document.get<double>());
    default:
      return null();
  }
}

}  // namespace fracture
