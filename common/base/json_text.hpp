// Writes JSON that contains untrusted text, such as file names, which are bytes and need not be UTF-8.
#pragma once

#include <exception>
#include <nlohmann/json.hpp>
#include <string>

namespace fracture {

/// Never throws because of the text: invalid UTF-8 becomes U+FFFD, whereas json::dump() throws. `indent` as
/// in dump().
template <class Json>
std::string json_text(const Json& value, int indent = -1) {
  return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}

/// The text as json_text() would write it, for comparison with text that was read back.
inline std::string as_utf8(const std::string& text) {
  return nlohmann::json::parse(json_text(nlohmann::json(text))).get<std::string>();
}

/// The message of a JSON exception for people, without the bracketed prefix that the library adds.
inline std::string json_trouble(const std::exception& error) {
  const std::string text = error.what();
  const std::size_t end = text.rfind("[json.exception.", 0) == 0 ? text.find("] ") : std::string::npos;
  return end == std::string::npos ? text : text.substr(end + 2);
}

}  // namespace fracture
