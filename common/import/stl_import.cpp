#include "common/import/stl_import.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "common/base/words.hpp"
#include "common/import/binary_numbers.hpp"
#include "common/import/limit_words.hpp"
#include "common/import/polygon_file.hpp"
#include "common/import/refused.hpp"
#include "common/import/text_scanner.hpp"

namespace fracture {
namespace {

constexpr std::size_t kStlHeader = 84;  ///< bytes: 80 of any content and the number of triangles
constexpr std::size_t kStlFacet = 50;   ///< bytes: 12 floats and the attribute

class BinaryStl {
 public:
  BinaryStl(std::span<const std::byte> bytes, std::uint64_t facets) : bytes_(bytes), facets_(facets) {}

  PolygonFile read(const ImportLimits& limits) {
    if (facets_ == 0) refuse(ErrorCode::kEmptyMesh, "The binary STL declares 0 triangles.");
    limit_faces(facets_, limits);
    find_object_color();
    file_.corners.reserve(3 * facets_);
    file_.face_end.reserve(facets_);
    for (std::uint64_t facet = 0; facet < facets_; ++facet) read_facet(facet, limits);
    file_.end_part({});
    file_.places.text = false;
    if (has_object_color_ && file_.colors.empty()) {
      const auto rounded = [](float c) { return std::round(static_cast<double>(c) * 1e6) / 1e6; };
      nlohmann::json material = plain_material({rounded(color_.x), rounded(color_.y), rounded(color_.z)});
      material.erase("doubleSided");
      file_.library.materials.push_back(std::move(material));
      file_.material = 0;
    }
    return std::move(file_);
  }

 private:
  void find_object_color() {
    const std::string_view header(reinterpret_cast<const char*>(bytes_.data()), kStlHeader);
    const std::size_t at = header.substr(0, 76).find("COLOR=");
    if (at == std::string_view::npos || at + 10 > 80) return;
    has_object_color_ = true;
    const auto channel = [&](std::size_t k) {
      return static_cast<float>(unsigned_at(bytes_, at + 6 + k, 1, ByteOrder::kLittle)) * (1.0f / 255.0f);
    };
    color_ = {channel(0), channel(1), channel(2), channel(3)};
  }

  void read_facet(std::uint64_t facet, const ImportLimits& limits) {
    const std::size_t at = kStlHeader + kStlFacet * facet;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::size_t place = at + 12 + 12 * corner;  // after the normal
      const auto coordinate = [&](std::size_t k) {
        return static_cast<double>(float_at(bytes_, place + 4 * k, ByteOrder::kLittle));
      };
      file_.corners.push_back(static_cast<std::uint32_t>(file_.positions.size()));
      file_.add_position({coordinate(0), coordinate(1), coordinate(2)}, place);
    }
    file_.end_face(limits);
    const auto attribute = static_cast<std::uint32_t>(unsigned_at(bytes_, at + 48, 2, ByteOrder::kLittle));
    if ((attribute & 0x8000u) == 0) return;
    if (file_.colors.empty()) file_.colors.assign(3 * facets_, color_);
    const auto channel = [&](unsigned shift) {
      return static_cast<float>(attribute >> shift & 31u) * (1.0f / 31.0f);
    };
    const Vec4f color = has_object_color_ ? Vec4f{channel(0), channel(5), channel(10), 1}
                                          : Vec4f{channel(10), channel(5), channel(0), 1};
    std::fill_n(file_.colors.begin() + static_cast<std::ptrdiff_t>(3 * facet), 3, color);
  }

  std::span<const std::byte> bytes_;
  std::uint64_t facets_;
  PolygonFile file_;
  bool has_object_color_ = false;
  Vec4f color_{0.6f, 0.6f, 0.6f, 0.6f};  ///< of facets without a colour in a file that has colours
};

class TextStl {
 public:
  explicit TextStl(std::string_view text) : scan_(text, "STL", false) { file_.places.bytes = text; }

  PolygonFile read(const ImportLimits& limits) {
    while (scan_.find_word()) {
      const std::size_t at = scan_.at();
      const std::string_view word = scan_.word_in_line();
      if (is_keyword(word, "vertex")) {
        read_vertex(at);
      } else if (is_keyword(word, "facet")) {
        end_facet(limits);
        begin_facet(at);
        skip_normal();
      } else if (is_keyword(word, "endloop") || is_keyword(word, "endfacet")) {
        end_facet(limits);
      } else if (is_keyword(word, "solid")) {
        end_facet(limits);
        end_solid();
        in_solid_ = true;
        name_ = read_name();
      } else if (is_keyword(word, "endsolid")) {
        end_facet(limits);
        end_solid();
        scan_.skip_line();
      }  // "outer", "loop", and words that some programs add
    }
    if (in_facet_)
      refuse(ErrorCode::kMalformedMesh, "The ASCII STL ends inside the facet that begins at " +
                                            scan_.place(facet_at_) +
                                            ". It was cut short: export or copy it again.");
    if (in_solid_)
      file_.remarks.warn(
          "The ASCII STL ends without \"endsolid\", so facets may be missing at its end. Export or copy it "
          "again if the solid is incomplete.");
    end_solid();
    if (file_.face_end.empty()) refuse(ErrorCode::kEmptyMesh, "The ASCII STL has no facets.");
    return std::move(file_);
  }

 private:
  void begin_facet(std::size_t at) {
    in_facet_ = true;
    facet_at_ = at;
  }

  /// Skips the rest of the line, up to "outer": numbers, words in their place, or nothing.
  void skip_normal() {
    for (;;) {
      scan_.find_word_in_line();
      const std::size_t at = scan_.at();
      const std::string_view word = scan_.word_in_line();
      if (word.empty()) return;
      if (is_keyword(word, "outer")) return scan_.seek(at);
    }
  }

  void read_vertex(std::size_t at) {
    if (!in_facet_) begin_facet(at);
    Vec3d p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = scan_.number("a coordinate");
    file_.corners.push_back(static_cast<std::uint32_t>(file_.positions.size()));
    file_.add_position(p, at);
    if (file_.positions.size() >= kNoIndex)
      refuse(ErrorCode::kTooLarge,
             std::string("The ASCII STL has more than 4,294,967,294 corners, which is the limit. ") +
                 kSmallerMesh);
  }

  void end_facet(const ImportLimits& limits) {
    if (!in_facet_) return;
    in_facet_ = false;
    const std::size_t begin = file_.face_end.empty() ? 0 : file_.face_end.back();
    const std::size_t count = file_.corners.size() - begin;
    if (count < 3)
      refuse(ErrorCode::kMalformedMesh, "The facet at " + scan_.place(facet_at_) + " of the ASCII STL has " +
                                            counted(count, "vertex", "vertices") +
                                            ", but a facet needs 3. Export the file again.");
    file_.end_face(limits);
  }

  void end_solid() {
    const std::size_t begin = file_.parts.empty() ? 0 : file_.parts.back().face_end;
    if (in_solid_ || begin != file_.face_end.size()) file_.end_part(std::move(name_));
    in_solid_ = false;
    name_.clear();
  }

  /// Reads the rest of a line "solid a name", or up to "facet normal" if the whole file is one line.
  std::string read_name() {
    std::string_view first;
    for (;;) {
      scan_.find_word_in_line();
      const std::size_t at = scan_.at();
      const std::string_view word = scan_.word_in_line();
      if (word.empty()) break;
      if (is_keyword(word, "facet")) {
        const std::size_t after = scan_.at();
        if (is_keyword(scan_.word_in_line(), "normal")) {
          scan_.seek(at);
          break;
        }
        scan_.seek(after);
      }
      if (first.empty()) first = word;
    }
    return std::string(first);
  }

  TextScanner scan_;
  PolygonFile file_;
  std::string name_;
  bool in_solid_ = false, in_facet_ = false;
  std::size_t facet_at_ = 0;
};

bool contains_keyword(std::string_view text, std::string_view lower) {
  const auto same = [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; };
  return std::search(text.begin(), text.end(), lower.begin(), lower.end(), same) != text.end();
}

PolygonFile read_stl(std::span<const std::byte> bytes, const ImportLimits& limits) {
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::uint64_t declared =
      bytes.size() < kStlHeader ? 0 : unsigned_at(bytes, 80, 4, ByteOrder::kLittle);
  if (bytes.size() >= kStlHeader && bytes.size() == kStlHeader + kStlFacet * declared)
    return BinaryStl(bytes, declared).read(limits);

  if (text.substr(0, 3) == "\xef\xbb\xbf") text.remove_prefix(3);  // byte order mark of UTF-8
  const std::size_t first = std::min(text.find_first_not_of(" \t\r\n"), text.size());
  // A binary file may begin with "solid", too. Unlike text, its header or its count contains a zero.
  const bool is_text = is_keyword(text.substr(first, 5), "solid") &&
                       text.substr(0, kStlHeader).find('\0') == std::string_view::npos;
  if (is_text && contains_keyword(text, "facet")) return TextStl(text).read(limits);
  if (is_text && contains_keyword(text, "endsolid"))
    refuse(ErrorCode::kEmptyMesh, "The ASCII STL has no facets.");
  if (bytes.size() < kStlHeader)
    refuse(ErrorCode::kMalformedMesh,
           "This is not an STL file: its " + std::to_string(bytes.size()) +
               " bytes contain neither an ASCII \"solid\" nor a binary header (84 bytes).");
  refuse(ErrorCode::kMalformedMesh,
         "The binary STL declares " + std::to_string(declared) + " triangles at byte 80, so it must have " +
             std::to_string(kStlHeader + kStlFacet * declared) + " bytes, but it has " +
             std::to_string(bytes.size()) + ", enough for " +
             std::to_string((bytes.size() - kStlHeader) / kStlFacet) +
             " triangles. Export or copy the file again.");
}

}  // namespace

Expected<Mesh> import_stl(std::span<const std::byte> bytes, const ImportLimits& limits) {
  try {
    return finish_polygon_file(read_stl(bytes, limits), limits);
  } catch (const Refused& refused) {
    return tl::unexpected<Error>(refused.error);
  }
}

}  // namespace fracture
