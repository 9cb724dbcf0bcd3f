#include "common/gltf/json_text.hpp"

#include <algorithm>

namespace fracture {
const Execution& JsonText::never_stopped() {
  static const Execution execution;
  return execution;
}

// Grows the text as std::string does, but with polls.
void JsonText::grow(std::size_t by) {
  std::string longer;
  longer.reserve(std::max(text_.size() + by, 2 * text_.capacity()));
  longer.swap(text_);
  append(longer);
}

void JsonText::append(std::string_view raw) {
  if (text_.capacity() - text_.size() < raw.size()) grow(raw.size());
  for (std::size_t at = 0; at < raw.size(); at += kBytesBetweenPolls) {
    pacer_.step(kBytesBetweenPolls / 64);
    text_ += raw.substr(at, kBytesBetweenPolls);
  }
}

JsonText& JsonText::value(std::string_view text) {
  static constexpr char kHex[] = "0123456789abcdef";
  make_room(text.size() + 3);
  separate();
  text_ += '"';
  std::size_t plain = 0;  // [plain, k) needs no escaping
  for (std::size_t k = 0; k < text.size(); ++k) {
    const char c = text[k];
    if (k % 4096 == 4095) pacer_.step(256);
    if (c != '"' && c != '\\' && static_cast<unsigned char>(c) >= 0x20) continue;
    append(text.substr(plain, k - plain));
    plain = k + 1;
    if (c == '"' || c == '\\') {
      append("\\");
      append({&c, 1});
    } else {
      append("\\u00");
      append({&kHex[c >> 4], 1});
      append({&kHex[c & 15], 1});
    }
  }
  append(text.substr(plain));
  append("\"");
  comma_ = true;
  return *this;
}

JsonText& JsonText::value(const nlohmann::json& document) {
  switch (document.type()) {
    case nlohmann::json::value_t::object:
      begin_object();
      for (const auto& [name, child] : document.items()) {
        value(std::string_view(name));  // keys of foreign documents need escaping
        make_room(1);
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
