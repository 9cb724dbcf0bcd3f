#include "common/import/obj_text.hpp"

#include <algorithm>
#include <charconv>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "common/base/id.hpp"
#include "common/base/words.hpp"
#include "common/import/limit_words.hpp"
#include "common/import/obj_lines.hpp"
#include "common/import/obj_scan.hpp"
#include "common/import/refused.hpp"
#include "common/import/text_words.hpp"

namespace fracture {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

[[noreturn]] void refuse_line(ErrorCode code, std::uint64_t line, const std::string& text) {
  refuse(code, "Line " + std::to_string(line) + " of the OBJ: " + text, {}, {{"line", line}});
}

/// Up to N numbers of a line. Words that are not numbers are NaN.
template <std::size_t N>
std::size_t take_numbers(std::string_view rest, std::array<double, N>& numbers) {
  const char *at = rest.data(), *const end = at + rest.size();
  for (std::size_t count = 0;; ++count) {
    while (at != end && blank_in_line(*at)) ++at;
    if (at == end || *at == '#') return count;
    double number = 0;
    if (!scan_number(at, end, number)) {
      std::string_view left(at, static_cast<std::size_t>(end - at));
      number = number_of(take_word(left)).value_or(kNotANumber);
      at = left.data();
    }
    if (count < N) numbers[count] = number;
  }
}

float as_float(double value) {
  constexpr double kMost = std::numeric_limits<float>::max();
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  return value > kMost ? kInfinite : value < -kMost ? -kInfinite : static_cast<float>(value);
}

/// The position in `count` numbers, at least three: x y z, x y z w, x y z r g b, or x y z r g b a. Tools that write colours
/// put them after z, so w and colours exclude each other.
Vec3d position_of(const std::array<double, 7>& n, std::size_t count) {
  if (count != 4 || n[3] == 1) return {n[0], n[1], n[2]};
  if (n[3] == 0) return {kNotANumber, kNotANumber, kNotANumber};
  return {n[0] / n[3], n[1] / n[3], n[2] / n[3]};
}

class ObjTextReader {
 public:
  ObjTextReader(std::string_view text, const ImportLimits& limits, ObjMaterials& materials)
      : whole_(text), limits_(limits), materials_(materials) {}

  ObjText read() {
    if (const std::size_t zero = whole_.find('\0'); zero != std::string_view::npos)
      refuse(ErrorCode::kMalformedMesh, "This is not an OBJ file: OBJ is text, but byte " +
                                            std::to_string(zero) +
                                            " is zero. State the file's actual format.");
    ObjLines lines(whole_);
    for (std::string_view line; lines.next(line);) {
      line_ = lines.number();
      const std::string_view keyword = take_value(line);
      if (!keyword.empty()) statement(keyword, line);
    }
    judge();
    return std::move(out_);
  }

 private:
  void statement(std::string_view keyword, std::string_view rest) {
    if (keyword == "v") return position(rest);
    if (keyword == "f") return face(rest);
    if (keyword == "vt") return uv(rest);
    if (keyword == "vn") return normal(rest);
    if (keyword == "usemtl") {
      const std::string_view name = without_blanks(rest);
      if (!name.empty()) material_ = materials_.use(name);
    } else if (keyword == "g") {
      const std::string_view name = without_blanks(rest);
      if (name == group_) return;
      group_ = name;
      new_object(name);
    } else if (keyword == "o") {
      const std::string_view name = without_blanks(rest);
      if (name.empty()) return;
      if (const auto it = objects_.find(name); it != objects_.end())
        object_ = it->second;
      else
        new_object(name);
    } else if (keyword == "mtllib") {
      materials_.load(rest);
    } else {
      other(keyword);
    }
  }

  /// Statements without faces. Any other keyword concerns display only (`s`, `mg`, `lod`, …) or belongs to a free-form
  /// element (`parm`, `end`, …).
  void other(std::string_view keyword) {
    if (keyword == "l") leave_out("line", "only faces have a surface");
    if (keyword == "p") leave_out("point", "only faces have a surface");
    if (keyword == "curv" || keyword == "curv2") leave_out("curve", "only faces have a surface");
    if (keyword == "surf") leave_out(kFreeForm, "free-form surfaces are not read; export them as polygons");
    if (keyword == "call") leave_out("call of another file", "only the given file is read");
  }

  void leave_out(const char* what, const char* reason) {
    const auto it = std::find_if(out_.left_out.begin(), out_.left_out.end(), [what](const ObjLeftOut& kind) {
      return kind.what == std::string_view(what);
    });
    if (it == out_.left_out.end())
      out_.left_out.push_back({what, reason, 1, line_});
    else
      ++it->count;
  }

  /// Counts memory before it is allocated.
  void count(std::size_t bytes) {
    bytes_ += bytes;
    if (bytes_ <= limits_.max_decoded_bytes) return;
    refuse(ErrorCode::kTooLarge,
           "Up to line " + grouped(line_) + ", the OBJ takes " + data_size(bytes_) +
               " in memory; the limit is " + decoded_limit(limits_.max_decoded_bytes) + ". " + kSmallerMesh,
           {}, {{"line", line_}, {"limit", limits_.max_decoded_bytes}});
  }

  void position(std::string_view rest) {
    std::array<double, 7> n{};
    const std::size_t numbers = take_numbers(rest, n);
    if (numbers < 3)
      refuse_line(ErrorCode::kMalformedMesh, line_,
                  "a vertex needs three numbers, but there are " + std::to_string(numbers) +
                      ". The file may be cut off; export it again.");
    count(sizeof(Vec3d));
    const Vec3d at = position_of(n, numbers);
    odd_positions_ = odd_positions_ || !FilePositions::fits(at);
    out_.positions.add(at);
    if (numbers == 5 || numbers > 7) leave_out("vertex data", "a vertex has 3, 4, 6 or 7 numbers");
    const bool colored = numbers == 6 || numbers == 7;
    if (!colored && out_.colors.empty()) return;
    count((out_.positions.size() - out_.colors.size()) * sizeof(Vec4f));
    const Vec4f color{as_float(n[3]), as_float(n[4]), as_float(n[5]), numbers == 7 ? as_float(n[6]) : 1.0f};
    out_.colors.resize(out_.positions.size(), Vec4f{1, 1, 1, 1});
    if (colored) out_.colors.back() = color;
  }

  void uv(std::string_view rest) {
    std::array<double, 3> n{};
    if (take_numbers(rest, n) == 0)
      refuse_line(
          ErrorCode::kMalformedMesh, line_,
          "a texture coordinate needs one to three numbers. The file may be cut off; export it again.");
    count(sizeof(Vec2f));
    out_.uvs.push_back({as_float(n[0]), as_float(n[1])});
  }

  void normal(std::string_view rest) {
    std::array<double, 3> n{};
    if (take_numbers(rest, n) < 3)
      refuse_line(ErrorCode::kMalformedMesh, line_,
                  "a normal needs three numbers. The file may be cut off; export it again.");
    count(sizeof(Vec3f));
    out_.normals.push_back({as_float(n[0]), as_float(n[1]), as_float(n[2])});
  }

  void new_object(std::string_view name) {
    count(sizeof(std::string) + 2 * name.size() + 64);
    object_ = static_cast<std::uint32_t>(out_.objects.size());
    out_.objects.emplace_back(name);
    objects_.emplace(name, object_);  // the first of several objects with one name stays
  }

  void face(std::string_view rest) {
    const std::size_t first = out_.position.size();
    const char *at = rest.data(), *const end = at + rest.size();
    for (;;) {
      while (at != end && blank_in_line(*at)) ++at;
      if (at == end || *at == '#') break;
      corner(at, end);
    }
    const std::size_t corners = out_.position.size() - first;
    if (corners < 3) {
      out_.position.resize(first);
      if (!out_.uv.empty()) out_.uv.resize(first);
      if (!out_.normal.empty()) out_.normal.resize(first);
      return leave_out("face", "it has fewer than three corners");
    }
    out_.triangles += corners - 2;
    if (out_.triangles > limits_.max_triangles)
      refuse(ErrorCode::kTooLarge,
             "Up to line " + grouped(line_) + ", the OBJ has " +
                 counted(out_.triangles, "triangle", "triangles") + "; the limit is " +
                 triangle_limit(limits_.max_triangles) + ". " + kSmallerMesh,
             {}, {{"line", line_}, {"triangles", out_.triangles}, {"limit", limits_.max_triangles}});
    if (object_ == kNoIndex) new_object({});
    if (out_.runs.empty() || out_.runs.back().object != object_ || out_.runs.back().material != material_) {
      count(sizeof(ObjRun));
      out_.runs.push_back({object_, material_, static_cast<std::uint32_t>(out_.corners_of_face.size()),
                           static_cast<std::uint32_t>(first)});
    }
    count(sizeof(std::uint32_t));
    out_.corners_of_face.push_back(static_cast<std::uint32_t>(corners));
  }

  /// v, v/t, v//n or v/t/n, up to a blank or the end of the line
  void corner(const char*& at, const char* end) {
    std::string_view rest(at, static_cast<std::size_t>(end - at));
    count(sizeof(std::uint32_t));
    const std::uint32_t v = index_at(at, end, rest, out_.positions.size(), highest_);
    out_.position.push_back(v);
    const auto more = [&] { return at != end && !blank_in_line(*at); };
    std::uint32_t t = kNoIndex, n = kNoIndex;
    if (more() && *at == '/') {
      ++at;
      if (more() && *at != '/') t = index_at(at, end, rest, out_.uvs.size(), out_.highest_uv);
      if (more() && *at == '/') {
        ++at;
        if (more()) n = index_at(at, end, rest, out_.normals.size(), out_.highest_normal);
      }
    }
    if (more()) refuse_corner(take_word(rest));
    set_corner(out_.uv, t);
    set_corner(out_.normal, n);
  }

  void set_corner(std::vector<std::uint32_t>& list, std::uint32_t index) {
    if (index == kNoIndex && list.empty()) return;
    count((out_.position.size() - list.size()) * sizeof(std::uint32_t));
    if (list.size() + 1 < out_.position.size()) list.resize(out_.position.size() - 1, kNoIndex);
    list.push_back(index);
  }

  /// Reads an index: from 1, or from -1 for the last value so far. Returns it from 0. `rest`: the line from this corner.
  std::uint32_t index_at(const char*& at, const char* end, std::string_view rest, std::size_t values,
                         ObjHighest& highest) {
    std::int64_t number = 0;
    if (!scan_index(at, end, number)) {
      if (end - at > 1 && *at == '+' && at[1] != '-') ++at;
      const auto [after, error] = std::from_chars(at, end, number);
      if (error != std::errc{}) refuse_corner(take_word(rest));
      at = after;
    }
    if (number == 0) refuse_corner(take_word(rest));
    if (number < 0) {
      if (number < -static_cast<std::int64_t>(values))
        refuse_line(ErrorCode::kMalformedMesh, line_,
                    "the corner " + quotation(take_word(rest)) + " counts back further than the " +
                        std::to_string(values) + " values before it. Export the file again.");
      return static_cast<std::uint32_t>(static_cast<std::int64_t>(values) + number);
    }
    const auto index = static_cast<std::uint64_t>(number - 1);
    if (index >= values && (highest.line == 0 || index > highest.index)) highest = {index, line_};
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(index, kNoIndex - 1));
  }

  [[noreturn]] void refuse_corner(std::string_view word) {
    refuse_line(
        ErrorCode::kMalformedMesh, line_,
        "the corner " + quotation(word) +
            " is not of the form v, v/t, v//n or v/t/n. Numbers begin at 1, or count backwards from -1. Export the file again.");
  }

  /// Refuses what only the whole file shows.
  void judge() {
    if (out_.positions.size() == 0)
      refuse(ErrorCode::kMalformedMesh,
             "This is not an OBJ file: no line begins with \"v \"; the file begins with " +
                 quotation(whole_.substr(0, 16)) + ". State the file's actual format.");
    if (out_.corners_of_face.empty()) refuse_without_faces();
    if (highest_.line != 0 && highest_.index >= out_.positions.size())
      refuse_line(ErrorCode::kMalformedMesh, highest_.line,
                  "a face uses vertex " + std::to_string(highest_.index + 1) + ", but the file has only " +
                      counted(out_.positions.size(), "vertex", "vertices") +
                      ". The file may be cut off; export it again.");
    for (const std::uint32_t v : out_.position) {
      if (odd_positions_ && !FilePositions::fits(out_.positions[v])) refuse_position(v);
      out_.positions.use(v);
    }
  }

  [[noreturn]] void refuse_without_faces() {
    for (const ObjLeftOut& kind : out_.left_out)
      if (kind.what == std::string_view(kFreeForm))
        refuse(ErrorCode::kUnsupportedFeature,
               "The OBJ has no faces, only free-form surfaces (surf, first on line " +
                   std::to_string(kind.line) + "), which are not read. Export it as polygons.",
               {}, {{"line", kind.line}});
    std::string others;
    for (const ObjLeftOut& kind : out_.left_out)
      others += (others.empty() ? " It has statements of these kinds: " : ", ") + std::string(kind.what);
    refuse(ErrorCode::kEmptyMesh, "The OBJ has " + counted(out_.positions.size(), "vertex", "vertices") +
                                      " but no faces." + others + (others.empty() ? "" : ".") +
                                      " Export it with its surface.");
  }

  /// Finds the vertex in the text again, to say what is wrong with it.
  [[noreturn]] void refuse_position(std::uint32_t wanted) {
    ObjLines lines(whole_);
    std::uint32_t v = 0;
    for (std::string_view line; lines.next(line);) {
      std::string_view rest = line;
      if (take_value(rest) != "v" || v++ != wanted) continue;
      std::array<double, 7> n{};
      const std::string_view values = rest;
      const std::size_t numbers = take_numbers(rest, n);
      const std::string vertex =
          "vertex " + std::to_string(wanted + 1) + " (" + quotation(without_blanks(line)) + ")";
      std::string_view left = values;
      for (std::string_view word = take_value(left); !word.empty(); word = take_value(left))
        if (!number_of(word))
          refuse_line(ErrorCode::kMalformedMesh, lines.number(),
                      quotation(word) + " in " + vertex +
                          " is not a number. Numbers have a decimal point, such as 1.5.");
      if (numbers == 4 && n[3] == 0)
        refuse_line(ErrorCode::kNotFinite, lines.number(),
                    vertex + " is at infinity: its fourth number (w) is 0. Remove w.");
      refuse(
          ErrorCode::kNotFinite,
          "Line " + std::to_string(lines.number()) + " of the OBJ: " + vertex +
              " has a coordinate that is not finite or exceeds 3.4e38, the largest float. Repair the mesh in a "
              "modelling tool.",
          {}, {{"line", lines.number()}, {"vertex", wanted}});
    }
    throw InternalError("an OBJ has fewer vertices when it is read again");
  }

  static constexpr const char* kFreeForm = "free-form surface";

  std::string_view whole_;
  const ImportLimits& limits_;
  ObjMaterials& materials_;
  ObjText out_;
  ObjHighest highest_;  ///< of positions
  std::map<std::string, std::uint32_t, std::less<>> objects_;
  std::string group_;
  std::uint32_t object_ = kNoIndex, material_ = kNoIndex;
  std::uint64_t line_ = 0, bytes_ = 0;
  bool odd_positions_ = false;  ///< some position does not fit
};

}  // namespace

ObjText read_obj_text(std::string_view text, const ImportLimits& limits, ObjMaterials& materials) {
  return ObjTextReader(text, limits, materials).read();
}

}  // namespace fracture
