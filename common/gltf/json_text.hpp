// Writes JSON directly into a string. No document is built first, because the writer must be fast enough for a frame.
// std::to_chars gives the shortest text that reads back as the same double (invariant I4). Texts may be hundreds
// of megabytes long, so they are written, and grow, in steps between which the execution is polled.
#pragma once

#include <charconv>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/pacer.hpp"
#include "common/base/vec.hpp"

namespace fracture {

/// The class adds commas; the caller is responsible for nesting and keys. Keys are trusted text and are not escaped.
/// Functions that write may throw Interrupted.
class JsonText {
 public:
  JsonText() : JsonText(never_stopped()) {}
  /// `execution` is borrowed.
  explicit JsonText(const Execution& execution) : pacer_(execution) {}

  const std::string& text() const { return text_; }
  std::string take() { return std::move(text_); }
  void reserve(std::size_t bytes) { text_.reserve(bytes); }

  JsonText& begin_object() { return open('{'); }
  JsonText& end_object() { return close('}'); }
  JsonText& begin_array() { return open('['); }
  JsonText& end_array() { return close(']'); }
  JsonText& key(std::string_view name) {
    make_room(name.size() + 4);
    text_.append(&",\""[comma_ ? 0 : 1], comma_ ? 2 : 1);
    text_ += name;
    text_.append("\":", 2);
    comma_ = false;
    return *this;
  }

  template <std::integral Integer>
  requires(!std::same_as<Integer, bool>) JsonText& value(Integer number) { return put_number(number); }
  /// Floats are converted to double first, which is exact. So every reader gets the stored bits back.
  JsonText& value(double number) {
    if (!std::isfinite(number)) throw InternalError("a number for the file is not finite");
    if (number == 0 && std::signbit(number)) return put("-0.0");  // some readers parse "-0" as an integer
    return put_number(number);
  }
  /// Writes the shortest text that reads back as the same float. It is for long lists of numbers that need no more
  /// precision. Numbers too large or too small for a float are written as doubles.
  JsonText& rounded(double number) {
    if (!(std::fabs(number) <= std::numeric_limits<float>::max())) return value(number);
    const auto rounded = static_cast<float>(number);
    return rounded == 0 ? value(number) : put_number(rounded);
  }
  JsonText& rounded(const Vec3d& v) {
    return begin_array().rounded(v.x).rounded(v.y).rounded(v.z).end_array();
  }
  JsonText& value(bool flag) { return put(flag ? "true" : "false"); }
  JsonText& value(std::string_view text);
  JsonText& value(const std::string& text) { return value(std::string_view(text)); }
  JsonText& value(const char* text) { return value(std::string_view(text)); }
  JsonText& value(const Vec3d& v) { return begin_array().value(v.x).value(v.y).value(v.z).end_array(); }
  JsonText& value(const std::vector<std::string>& texts) {
    begin_array();
    for (const std::string& text : texts) value(text);
    return end_array();
  }
  JsonText& null() { return put("null"); }
  /// Writes a finished document with its keys in the document's order.
  JsonText& value(const nlohmann::json& document);

  /// Writes text that is JSON already, unchanged.
  JsonText& value_text(std::string_view json) {
    make_room(1);
    separate();
    append(json);
    comma_ = true;
    return *this;
  }

  template <class T>
  JsonText& member(std::string_view name, const T& v) {
    return key(name).value(v);
  }

 private:
  void make_room(std::size_t bytes) {
    pacer_.step();
    if (text_.capacity() - text_.size() < bytes) grow(bytes);
  }
  void grow(std::size_t by);
  /// Appends text of any length.
  void append(std::string_view raw);
  void separate() {
    if (comma_) text_ += ',';
  }
  JsonText& open(char bracket) {
    make_room(2);
    separate();
    text_ += bracket;
    comma_ = false;
    return *this;
  }
  JsonText& close(char bracket) {
    make_room(1);
    text_ += bracket;
    comma_ = true;
    return *this;
  }
  JsonText& put(std::string_view raw) {
    make_room(raw.size() + 1);
    separate();
    text_ += raw;
    comma_ = true;
    return *this;
  }
  static const Execution& never_stopped();

  template <class Number>
  JsonText& put_number(Number number) {
    char digits[32];
    const auto result = std::to_chars(digits, digits + sizeof(digits), number);
    return put({digits, static_cast<std::size_t>(result.ptr - digits)});
  }

  std::string text_;
  bool comma_ = false;
  Pacer pacer_;
};

}  // namespace fracture
