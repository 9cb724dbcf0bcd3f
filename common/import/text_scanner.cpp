#include "common/import/text_scanner.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <system_error>

#include "common/import/refused.hpp"
#include "common/import/text_words.hpp"

namespace fracture {
namespace {

bool ends_line(char c) { return c == '\n' || c == '\r'; }

}  // namespace

std::string FilePlaces::operator()(std::size_t at) const {
  if (!text) return "byte " + std::to_string(at);
  std::uint64_t line = 1;
  const std::size_t end = std::min(at, bytes.size());
  for (std::size_t k = 0; k < end; ++k)
    line += bytes[k] == '\n' || (bytes[k] == '\r' && (k + 1 == bytes.size() || bytes[k + 1] != '\n'));
  return "line " + std::to_string(line);
}

bool is_keyword(std::string_view word, std::string_view lower) {
  return std::equal(word.begin(), word.end(), lower.begin(), lower.end(),
                    [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; });
}

bool TextScanner::find_word_in_line() {
  while (at_ < text_.size() && blank_in_line(text_[at_])) ++at_;
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
  if (at_ >= text_.size() || blank_in_line(text_[at_]) || ends_line(text_[at_])) return true;
  return comments_ && text_[at_] == '#' &&
         (at_ == 0 || text_[at_ - 1] != '.');  // 1.#IND is a number, not 1 and a comment
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
                                        place(at_) + " but has " + quotation(rest.word_in_line()) +
                                        ". Correct the line, or export the file again.");
}

double TextScanner::number(const char* what) {
  require_word(what);
  const std::size_t begin = at_;
  while (!at_word_end()) ++at_;
  const std::optional<double> value = number_of(text_.substr(begin, at_ - begin));
  if (value) return *value;
  at_ = begin;
  refuse_word(what);
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
