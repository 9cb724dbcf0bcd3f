// Reads the words and numbers of a text file, with any line end (LF, CRLF, CR) and in any locale. Errors name the line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace fracture {

/// Names places in a file, for error messages: "line 12" of a text, "byte 345" of binary data.
struct FilePlaces {
  std::string_view bytes;  ///< the whole file
  bool text = true;

  /// Lines are counted from 1, bytes from 0. Takes time linear in `at`.
  std::string operator()(std::size_t at) const;
};

/// Whether two words differ at most in the case of ASCII letters. `lower` must be in lower case.
bool is_keyword(std::string_view word, std::string_view lower);

/// Reads words and numbers, from front to back, in time linear in the file. Throws Refused.
class TextScanner {
 public:
  /// `format`: its name in error messages, e.g. "STL". `comments`: comments extend from # to the end of a line.
  TextScanner(std::string_view text, const char* format, bool comments)
      : text_(text), format_(format), comments_(comments) {}

  std::size_t at() const { return at_; }
  void seek(std::size_t at) { at_ = at; }
  std::size_t remaining() const { return text_.size() - at_; }
  /// "line 12".
  std::string place(std::size_t at) const { return FilePlaces{text_}(at); }

  /// Goes to the next word of this line. Returns false at the end of the line.
  bool find_word_in_line();
  /// Goes to the next word of the file. Returns false at the end of the file.
  bool find_word();
  /// The next word of this line; empty at the end of the line.
  std::string_view word_in_line();
  /// Goes to the end of this line.
  void skip_line();

  /// Reads the next number of the file (number_of() in text_words.hpp). `what`: the value in words, for errors: "a coordinate".
  /// Errors: kMalformedMesh if the next word is not a number or if the file ends.
  double number(const char* what);
  /// Reads a whole number of at least 0. Errors: kMalformedMesh.
  std::uint64_t count(const char* what);
  /// Goes past the next word of the file, whatever it is. Errors: kMalformedMesh if the file ends.
  void skip_word(const char* what);

 private:
  void require_word(const char* what);
  [[noreturn]] void refuse_word(const char* what) const;
  bool at_word_end() const;

  std::string_view text_;
  const char* format_;
  bool comments_;
  std::size_t at_ = 0;
};

}  // namespace fracture
