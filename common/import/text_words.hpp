// Words and numbers in lines of text. Nothing here depends on the locale.
#pragma once

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace fracture {

inline bool blank_in_line(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

/// Removes blanks at both ends.
inline std::string_view without_blanks(std::string_view text) {
  while (!text.empty() && blank_in_line(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank_in_line(text.back())) text.remove_suffix(1);
  return text;
}

/// Removes the first word from the rest of a line and returns it. Empty at the end of the line.
inline std::string_view take_word(std::string_view& rest) {
  const char *at = rest.data(), *const end = at + rest.size();
  while (at != end && blank_in_line(*at)) ++at;
  const char* const begin = at;
  while (at != end && !blank_in_line(*at)) ++at;
  rest = {at, static_cast<std::size_t>(end - at)};
  return {begin, static_cast<std::size_t>(at - begin)};
}

/// The same for lines that may end with a comment ("# …"), which counts as the end of the line.
inline std::string_view take_value(std::string_view& rest) {
  const std::string_view word = take_word(rest);
  if (word.empty() || word.front() != '#') return word;
  rest = {};
  return {};
}

/// A number that std::from_chars does not read: a magnitude beyond that of doubles (which becomes an infinity or zero), or
/// the names of values that are not numbers ("-nan(ind)", "1.#QNAN", "-1.#IND"). Nothing for any other word.
std::optional<double> unusual_number(std::string_view word);

/// The double nearest to a word, with an optional sign. Nothing if the whole word is not a number.
inline std::optional<double> number_of(std::string_view word) {
  const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
  const char *const begin = word.data() + (plus ? 1 : 0), *const end = word.data() + word.size();
  double value = 0;
  const auto [at, error] = std::from_chars(begin, end, value);
  if (error == std::errc{} && at == end) return value;
  return unusual_number(word);
}

/// The text in quotation marks for a message: valid UTF-8, printable, and not too long.
std::string quotation(std::string_view text);

}  // namespace fracture
