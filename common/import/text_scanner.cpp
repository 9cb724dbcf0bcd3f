#include "common/import/text_scanner.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>

#include "common/import/refused.hpp"

namespace fracture {
namespace {

bool ends_line(char c) { return c == '\n' || c == '\r'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

/// Whether a decimal number that no double can represent is too large; otherwise, it is too small. Its sign is already removed.
bool is_huge(std::string_view number) {
  const std::size_t exponent_at = number.find_first_of("eE");
  const std::string_view digits = number.substr(0, exponent_at);
  const std::size_t point = std::min(digits.find('.'), digits.size());
  const std::size_t first = digits.find_first_of("123456789");
  if (first == std::string_view::npos) return false;
  // The position of the first digit that is not 0, relative to the decimal point.
  std::int64_t magnitude = static_cast<std::int64_t>(point) - static_cast<std::int64_t>(first);
  if (exponent_at != std::string_view::npos) {
    std::string_view exponent = number.substr(exponent_at + 1);
    const bool negative = exponent.substr(0, 1) == "-";
    if (negative || exponent.substr(0, 1) == "+") exponent.remove_prefix(1);
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(exponent.data(), exponent.data() + exponent.size(), value);
    if (error != std::errc{}) return !negative;  // an exponent of more than 18 digits decides alone
    magnitude += negative ? -value : value;
  }
  return magnitude > 0;
}

}  // namespace

std::string FilePlaces::operator()(std::size_t at) const {
  if (!text) return "byte " + std::to_string(at);
  std::uint64_t line = 1;
  const std::size_t end = std::min(at, bytes.size());
  for (std::size_t k = 0; k < end; ++k)
    line += bytes[k] == '\n' || (bytes[k] == '\r' && (k + 1 == bytes.size() || bytes[k + 1] != '\n'));
  return "line " + std::to_string(line);
}

std::string quoted_word(std::string_view word) {
  constexpr std::size_t kMost = 40;
  std::string shown = "\"";
  for (const char c : word.substr(0, kMost)) shown += c >= 0x20 && c < 0x7f ? c : '.';
  return shown + (word.size() > kMost ? "...\"" : "\"");
}

bool is_keyword(std::string_view word, std::string_view lower) {
  return std::equal(word.begin(), word.end(), lower.begin(), lower.end(),
                    [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; });
}

bool TextScanner::find_word_in_line() {
  while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
  if (at_ < text_.size() && comments_ && text_[at_] == '#') skip_line();
  return at_ < text_.size() && !ends_line(text_[at_]);
}

bool TextScanner::find_word() {
  while (!find_word_in_line()) {
    if (at_ >= text_.size()) return false;
    ++at_;  // the end of the line
  }
  return true;
}

std::string_view TextScanner::word_in_line() {
  if (!find_word_in_line()) return {};
  const std::size_t begin = at_;
  while (!at_word_end()) ++at_;
  return text_.substr(begin, at_ - begin);
}

void TextScanner::skip_line() {
  while (at_ < text_.size() && !ends_line(text_[at_])) ++at_;
}

bool TextScanner::at_word_end() const {
  return at_ >= text_.size() || is_blank(text_[at_]) || ends_line(text_[at_]) ||
         (comments_ && text_[at_] == '#');
}

void TextScanner::require_word(const char* what) {
  if (find_word()) return;
  refuse(ErrorCode::kMalformedMesh, std::string("The ") + format_ + " file ends at " + place(text_.size()) +
                                        ", but " + what +
                                        " must follow. It was cut short: export or copy it again.");
}

void TextScanner::refuse_word(const char* what) const {
  TextScanner rest = *this;
  refuse(ErrorCode::kMalformedMesh, std::string("The ") + format_ + " file needs " + what + " at " +
                                        place(at_) + " but has " + quoted_word(rest.word_in_line()) +
                                        ". Correct the line, or export the file again.");
}

double TextScanner::number(const char* what) {
  require_word(what);
  const char* const begin = text_.data() + at_;
  const char* const end = text_.data() + text_.size();
  const bool negative = *begin == '-';
  const char* const digits = begin + (negative || *begin == '+');
  double value = 0;
  if (digits == end || *digits == '-' || *digits == '+') refuse_word(what);
  const auto [past, error] = std::from_chars(digits, end, value);
  if (error == std::errc::invalid_argument) refuse_word(what);
  if (error == std::errc::result_out_of_range)
    value = is_huge({digits, static_cast<std::size_t>(past - digits)}) ? HUGE_VAL : 0.0;
  const std::size_t word_at = at_;
  at_ = static_cast<std::size_t>(past - text_.data());
  // Microsoft's 1.#IND, 1.#QNAN and 1.#INF, and the rest of nan(ind).
  const bool microsoft =
      std::string_view(digits, static_cast<std::size_t>(end - digits)).substr(0, 3) == "1.#" &&
      end - past > 1 && (past[1] == 'I' || past[1] == 'Q' || past[1] == 'S');
  if (microsoft || std::isnan(value)) {
    value = std::numeric_limits<double>::quiet_NaN();
    at_ += microsoft;
    while (!at_word_end()) ++at_;
  }
  if (!at_word_end()) {
    at_ = word_at;
    refuse_word(what);
  }
  return negative ? -value : value;
}

std::uint64_t TextScanner::count(const char* what) {
  require_word(what);
  std::uint64_t value = 0;
  const char* const begin = text_.data() + at_;
  const auto [past, error] = std::from_chars(begin, text_.data() + text_.size(), value);
  const std::size_t word_at = at_;
  at_ = static_cast<std::size_t>(past - text_.data());
  if (error != std::errc{} || !at_word_end()) {
    at_ = word_at;
    refuse_word(what);
  }
  return value;
}

void TextScanner::skip_word(const char* what) {
  require_word(what);
  while (!at_word_end()) ++at_;
}

}  // namespace fracture
