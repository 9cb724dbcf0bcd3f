#include "common/import/ply_header.hpp"

#include <algorithm>
#include <array>
#include <charconv>

#include "common/base/text.hpp"
#include "common/import/refused.hpp"
#include "common/import/text_scanner.hpp"
#include "common/import/text_words.hpp"

namespace fracture {
namespace {

/// Longer than any header with thousands of comments. Limits the search for end_header.
constexpr std::size_t kMaxPlyHeader = 1u << 20;

struct PlyTypeName {
  std::string_view old_name, new_name;
  PlyType type;
};
constexpr PlyTypeName kPlyTypes[] = {
    {"char", "int8", PlyType::kInt8},      {"uchar", "uint8", PlyType::kUint8},
    {"short", "int16", PlyType::kInt16},   {"ushort", "uint16", PlyType::kUint16},
    {"int", "int32", PlyType::kInt32},     {"uint", "uint32", PlyType::kUint32},
    {"float", "float32", PlyType::kFloat}, {"double", "float64", PlyType::kDouble},
};

class PlyHeaderReader {
 public:
  explicit PlyHeaderReader(std::string_view file) : file_(file), cr_only_(ends_with_cr(file)) {}

  PlyHeader read() {
    if (file_.substr(0, 3) != "ply" || file_.size() < 4 || trimmed(next_line()) != "ply")
      refuse(ErrorCode::kMalformedMesh,
             "This is not a PLY file: it has to begin with the line \"ply\" but begins with " +
                 quotation(file_.substr(0, 16)) + ".");
    bool has_format = false;
    for (;;) {
      if (at_ >= file_.size() || at_ > kMaxPlyHeader)
        refuse(ErrorCode::kMalformedMesh, "The PLY has no line \"end_header\" in its first " +
                                              std::to_string(std::min(at_, file_.size())) + " bytes.");
      line_at_ = at_;
      TextScanner line(next_line(), "PLY", false);
      const std::string_view keyword = line.word_in_line();
      if (keyword == "end_header") break;
      if (keyword == "format") {
        read_format(line.word_in_line());
        has_format = true;
      } else if (keyword == "element") {
        read_element(line);
      } else if (keyword == "property") {
        read_property(line);
      } else if (keyword == "comment") {
        read_comment(line);
      }
    }
    if (!has_format) refuse(ErrorCode::kMalformedMesh, "The PLY header has no line \"format\".");
    header_.end = at_;
    check_sizes();
    return std::move(header_);
  }

 private:
  static bool ends_with_cr(std::string_view file) {
    const std::size_t end = file.find_first_of("\r\n");
    return end != std::string_view::npos && file[end] == '\r' && file.substr(end + 1, 1) != "\n";
  }

  std::string_view next_line() {
    const std::size_t begin = at_;
    const std::size_t end = std::min(file_.find_first_of("\r\n", at_), file_.size());
    at_ = end;
    if (at_ < file_.size() && file_[at_] == '\r' && !cr_only_) ++at_;
    if (at_ < file_.size() && file_[at_] == (cr_only_ ? '\r' : '\n')) ++at_;
    // A line whose line ending differs from the first line's.
    at_ = std::max(at_, std::min(end + 1, file_.size()));
    return file_.substr(begin, end - begin);
  }

  [[noreturn]] void refuse_line(const std::string& what) const {
    refuse(ErrorCode::kMalformedMesh,
           "The PLY header " + what + " at " + FilePlaces{file_}(line_at_) + ". Export the file again.");
  }

  void read_format(std::string_view format) {
    if (format == "ascii")
      header_.encoding = PlyEncoding::kText;
    else if (format == "binary_little_endian")
      header_.encoding = PlyEncoding::kLittleEndian;
    else if (format == "binary_big_endian")
      header_.encoding = PlyEncoding::kBigEndian;
    else
      refuse_line("names the unknown format " + quotation(format) +
                  " (not ascii, binary_little_endian or binary_big_endian)");
  }

  void read_element(TextScanner& line) {
    PlyElement element;
    element.name = line.word_in_line();
    const std::string_view count = line.word_in_line();
    const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (count.empty() || error != std::errc{} || end != count.data() + count.size())
      refuse_line("has an element without a count");
    for (const PlyElement& other : header_.elements)
      if (other.name == element.name)
        refuse_line("declares the element " + quotation(element.name) + " twice");
    if (header_.elements.size() >= 1000) refuse_line("declares more than 1,000 elements");
    header_.elements.push_back(std::move(element));
  }

  PlyType read_type(std::string_view word) const {
    for (const PlyTypeName& t : kPlyTypes)
      if (word == t.old_name || word == t.new_name) return t.type;
    refuse_line("has a property of unknown type " + quotation(word));
  }

  void read_property(TextScanner& line) {
    if (header_.elements.empty()) refuse_line("has a property before any element");
    PlyProperty property;
    std::string_view type = line.word_in_line();
    if (type == "list") {
      property.length = read_type(line.word_in_line());
      if (property.length == PlyType::kFloat || property.length == PlyType::kDouble)
        refuse_line("has a list whose length is not a whole number");
      type = line.word_in_line();
    }
    property.type = read_type(type);
    property.name = line.word_in_line();
    header_.elements.back().properties.push_back(std::move(property));
  }

  void read_comment(TextScanner& line) {
    if (line.word_in_line() != "TextureFile" || !line.find_word_in_line()) return;
    const std::size_t at = line.at();
    line.skip_line();
    const std::string_view whole = file_.substr(line_at_);
    header_.textures.emplace_back(trimmed(whole.substr(at, line.at() - at)));
  }

  /// Text: a value is at least one digit and a blank, which may be missing after the last one.
  void check_sizes() const {
    const bool text = header_.encoding == PlyEncoding::kText;
    std::uint64_t remaining = file_.size() - header_.end;
    for (const PlyElement& element : header_.elements) {
      std::uint64_t each = 0;
      for (const PlyProperty& property : element.properties)
        each += text ? 2 : ply_bytes(property.length.value_or(property.type));
      if (each == 0) continue;
      if (element.count > (remaining + (text ? 1 : 0)) / each)
        refuse(ErrorCode::kMalformedMesh,
               "The PLY declares " + std::to_string(element.count) + " " + quotation(element.name) +
                   " elements (at least " + std::to_string(each) + " bytes each), but only " +
                   std::to_string(remaining) + " bytes are left for them. Export or copy the file again.");
      remaining -= std::min(remaining, element.count * each);
    }
  }

  std::string_view file_;
  bool cr_only_;
  std::size_t at_ = 0, line_at_ = 0;
  PlyHeader header_;
};

}  // namespace

std::size_t ply_bytes(PlyType type) {
  constexpr std::array<std::size_t, 8> kBytes{1, 1, 2, 2, 4, 4, 4, 8};
  return kBytes[static_cast<std::size_t>(type)];
}

PlyHeader read_ply_header(std::string_view file) { return PlyHeaderReader(file).read(); }

}  // namespace fracture
