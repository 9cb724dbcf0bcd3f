// JSON as text where strangers have a say in it: names of files are bytes, and need not be UTF-8.
#pragma once

#include <exception>
#include <nlohmann/json.hpp>
#include <string>

namespace fracture {

/// Never throws for what a text holds: what is no UTF-8 becomes U+FFFD, where json::dump() alone throws. `indent` as there.
template <class Json>
std::string json_text(const Json& value, int indent = -1) {
  return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}

/// As json_text() writes it, so that it can be compared with what was read from there.
inline std::string as_utf8(const std::string& text) {
  return nlohmann::json::parse(json_text(nlohmann::json(text))).get<std::string>();
}

/// What went wrong in words for people: without the number that the library puts before them in brackets.
inline std::string json_trouble(const std::exception& error) {
  const std::string text = error.what();
  const std::size_t end = text.rfind("[json.exception.", 0) == 0 ? text.find("] ") : std::string::npos;
  return end == std::string::npos ? text : text.substr(end + 2);
}

}  // namespace fracture
