// Splits OBJ and MTL text into lines.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace fracture {

/// The lines of a text, in time linear in its length. A line ends with LF, CR LF or CR, whatever the other lines end with. A
/// backslash at the end of a line joins it with the next line. In a comment, also after a statement, it does not, because a
/// path may end with one. A byte order mark (UTF-8) is skipped.
class ObjLines {
 public:
  explicit ObjLines(std::string_view text) : text_(text.starts_with("\xef\xbb\xbf") ? text.substr(3) : text) {
    lf_ = find('\n');
    cr_ = find('\r');
  }

  /// Returns false after the last line. The line is valid until the next call.
  bool next(std::string_view& line) {
    if (at_ >= text_.size()) return false;
    number_ = read_ + 1;
    line = physical();
    const auto goes_on = [&] { return line.ends_with('\\') && at_ < text_.size() && !ends_in_comment(line); };
    if (!goes_on()) return true;
    for (joined_.clear(); goes_on(); line = physical()) joined_ += line.substr(0, line.size() - 1);
    joined_ += line;
    line = joined_;
    return true;
  }
  /// The number of the line, from 1. Joined lines have the number of the first.
  std::uint64_t number() const { return number_; }

 private:
  /// Whether a word of the line begins with #.
  static bool ends_in_comment(std::string_view line) {
    for (std::size_t at = line.find('#'); at != std::string_view::npos; at = line.find('#', at + 1))
      if (at == 0 || line[at - 1] == ' ' || line[at - 1] == '\t') return true;
    return false;
  }
  std::size_t find(char end) const {
    const void* const found =
        at_ < text_.size() ? std::memchr(text_.data() + at_, end, text_.size() - at_) : nullptr;
    return found ? static_cast<std::size_t>(static_cast<const char*>(found) - text_.data()) : text_.size();
  }
  std::string_view physical() {
    if (lf_ < at_) lf_ = find('\n');
    if (cr_ < at_) cr_ = find('\r');
    const std::size_t end = std::min(lf_, cr_);
    const std::string_view line = text_.substr(at_, end - at_);
    at_ = std::min(text_.size(), end + (cr_ + 1 == lf_ && end == cr_ ? 2 : 1));
    ++read_;
    return line;
  }

  std::string_view text_;
  std::size_t at_ = 0, lf_ = 0, cr_ = 0;  ///< the next byte to read, and the next LF and CR from there
  std::uint64_t read_ = 0, number_ = 0;
  std::string joined_;
};

}  // namespace fracture
