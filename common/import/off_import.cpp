#include "common/import/off_import.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include "common/base/words.hpp"
#include "common/import/binary_numbers.hpp"
#include "common/import/polygon_file.hpp"
#include "common/import/refused.hpp"
#include "common/import/text_scanner.hpp"
#include "common/import/text_words.hpp"

namespace fracture {
namespace {

/// The values that each vertex has, by the prefixes of the header.
struct OffVertex {
  bool uv = false, color = false, normal = false, homogeneous = false, dimension = false;
};

/// Reads the header and the text form.
class OffReader {
 public:
  OffReader(std::span<const std::byte> bytes, const ImportLimits& limits)
      : bytes_(bytes),
        limits_(limits),
        text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
        scan_(text_, "OFF", true) {
    file_.places.bytes = text_;
  }

  PolygonFile read() {
    if (text_.substr(0, 3) == "\xef\xbb\xbf") scan_.seek(3);  // byte order mark of UTF-8
    read_keyword();
    const std::size_t after = scan_.at();
    if (scan_.word_in_line() == "BINARY") {
      read_binary();
    } else {
      scan_.seek(after);
      read_text();
    }
    finish_colors();
    file_.end_part({});
    if (colored_faces_ > 0)
      file_.dropped.push_back(
          {"face colours", counted(colored_faces_, "face", "faces"), "only vertex colours are read"});
    const double grey = file_.colors.empty() ? 0.6 : 1.0;  // vertex colours are multiplied by it
    file_.library.materials.push_back(plain_material({grey, grey, grey}));
    file_.material = 0;
    return std::move(file_);
  }

 private:
  void read_keyword() {
    scan_.find_word();
    const std::size_t begin = scan_.at();
    const std::string_view word = scan_.word_in_line();
    const std::size_t name = word.find("OFF");
    const auto other = [&] {
      refuse(
          ErrorCode::kMalformedMesh,
          "This is not an OFF file: it has to begin with \"OFF\" (ST, C, N, 4 or n may precede it) but begins "
          "with " +
              quotation(word) + ".");
    };
    if (name == std::string_view::npos) other();
    std::string_view prefix = word.substr(0, name);
    const auto take = [&prefix](std::string_view letters) {
      if (prefix.substr(0, letters.size()) != letters) return false;
      prefix.remove_prefix(letters.size());
      return true;
    };
    while (!prefix.empty()) {
      bool* const has = take("ST")  ? &vertex_.uv
                        : take("C") ? &vertex_.color
                        : take("N") ? &vertex_.normal
                        : take("4") ? &vertex_.homogeneous
                        : take("n") ? &vertex_.dimension
                                    : nullptr;
      if (has == nullptr || *has) other();
      *has = true;
    }
    const std::string_view rest = word.substr(name + 3);  // "OFF490 518 0" is in collections of shapes
    if (!rest.empty() && (rest[0] < '0' || rest[0] > '9')) other();
    scan_.seek(begin + name + 3);
  }

  void read_text() {
    if (vertex_.dimension) check_dimension(scan_.count("the dimension"));
    const std::uint64_t vertices = scan_.count("the number of vertices");
    const std::uint64_t faces = scan_.count("the number of faces");
    skip_edges();
    constexpr std::uint64_t kVertexBytes = 6;  // "0 0 0\n"
    constexpr std::uint64_t kFaceBytes = 2;    // a face without corners, "0\n"
    check_counts(vertices, kVertexBytes, faces, kFaceBytes, scan_.remaining() + 1);
    for (std::uint64_t v = 0; v < vertices; ++v) read_vertex(v, vertices);
    for (std::uint64_t f = 0; f < faces; ++f) read_face(f, faces);
  }

  /// The third count, which some files omit. It is on the line of the others or alone on the next one.
  void skip_edges() {
    if (!scan_.word_in_line().empty()) return;
    const std::size_t line = scan_.at();
    scan_.find_word();
    scan_.word_in_line();
    if (!scan_.word_in_line().empty()) scan_.seek(line);
  }

  void check_dimension(std::uint64_t dimension) {
    if (dimension != 3)
      refuse(ErrorCode::kUnsupportedFeature,
             "The OFF file has " + std::to_string(dimension) + " dimensions; only 3 are supported.");
  }

  void check_counts(std::uint64_t vertices, std::uint64_t vertex_bytes, std::uint64_t faces,
                    std::uint64_t face_bytes, std::uint64_t remaining) {
    if (vertices > remaining / vertex_bytes || faces > remaining / face_bytes ||
        vertices * vertex_bytes + faces * face_bytes > remaining)
      refuse(ErrorCode::kMalformedMesh,
             "The OFF file declares " + counted(vertices, "vertex", "vertices") + " (at least " +
                 std::to_string(vertex_bytes) + " bytes each) and " + counted(faces, "face", "faces") +
                 " (at least " + std::to_string(face_bytes) + "), but only " +
                 counted(remaining, "byte follows", "bytes follow") + ". Export or copy the file again.");
    if (faces == 0) refuse(ErrorCode::kEmptyMesh, "The OFF file declares no faces.");
    limit_faces(faces, limits_);
    limit_vertices(
        vertices,
        12 + 8 * unsigned{vertex_.uv} + 16 * unsigned{vertex_.color} + 12 * unsigned{vertex_.normal},
        limits_);
    vertices_ = vertices;
  }

  void require_record(const char* kind, std::uint64_t index, std::uint64_t count) {
    if (scan_.find_word()) return;
    refuse(ErrorCode::kMalformedMesh, "The OFF file ends at " + scan_.place(text_.size()) + ", after " +
                                          std::to_string(index) + " of " + std::to_string(count) + " " +
                                          kind + ". It was cut short: export or copy it again.");
  }

  void read_vertex(std::uint64_t index, std::uint64_t count) {
    require_record("vertices", index, count);
    const std::size_t at = scan_.at();
    Vec3d p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = scan_.number("a coordinate");
    add_vertex(p, vertex_.homogeneous ? scan_.number("a coordinate") : 1, at);
    if (vertex_.normal) {
      Vec3d n;
      for (int axis = 0; axis < 3; ++axis) n[axis] = scan_.number("a normal");
      file_.normals.push_back({static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)});
    }
    if (vertex_.color || vertex_.uv) read_color_and_uv(at);
    scan_.skip_line();
  }

  /// A colour has any number of values up to 4, so the line's end decides which of them are texture coordinates.
  void read_color_and_uv(std::size_t vertex_at) {
    std::array<double, 6> values{};
    std::size_t count = 0;
    while (count < (vertex_.color ? 4u : 0u) + (vertex_.uv ? 2u : 0u) && scan_.find_word_in_line())
      values[count++] = scan_.number("a colour or texture coordinate");
    if (vertex_.uv) {
      if (count < 2)
        refuse(ErrorCode::kMalformedMesh, "The vertex at " + scan_.place(vertex_at) +
                                              " of the OFF file has no texture coordinates, but the header "
                                              "announces them (ST). Export the file again.");
      count -= 2;
      file_.uvs.push_back({static_cast<float>(values[count]), static_cast<float>(values[count + 1])});
    }
    if (vertex_.color) add_color(values.data(), count);
  }

  void add_vertex(const Vec3d& p, double w, std::size_t at) {
    file_.add_position(w == 1 ? p : Vec3d{p.x / w, p.y / w, p.z / w}, at);
  }

  /// Fewer than three values are the index of a colour map, which the file does not contain.
  void add_color(const double* values, std::size_t count) {
    const auto value = [values](std::size_t k) { return static_cast<float>(values[k]); };
    if (count < 3) {
      ++uncolored_;
      file_.colors.push_back({kNoColor, kNoColor, kNoColor, kNoColor});
      return;
    }
    file_.colors.push_back({value(0), value(1), value(2), count > 3 ? value(3) : kNoColor});
  }

  void finish_colors() {
    if (uncolored_ > 0)
      file_.dropped.push_back({"vertex colours", counted(uncolored_, "vertex", "vertices"),
                               "indexed colours need a colour map, which the file does not contain"});
    if (uncolored_ == file_.colors.size()) file_.colors.clear();
    bool bytes = false;
    for (const Vec4f& c : file_.colors) bytes |= c.x > 1 || c.y > 1 || c.z > 1 || c.w > 1;
    const float scale = bytes ? 255.0f : 1.0f;
    for (Vec4f& c : file_.colors)
      for (float* channel : {&c.x, &c.y, &c.z, &c.w})
        *channel = *channel == kNoColor ? 1.0f : *channel / scale;
  }

  /// `most`: the number of indices for which the rest of the file has room.
  void require_corners(std::uint64_t corners, std::uint64_t most, std::size_t at) const {
    if (corners > most)
      refuse(ErrorCode::kMalformedMesh, "The face at " + file_.places(at) + " of the OFF file has " +
                                            std::to_string(corners) + " corners, but at most " +
                                            std::to_string(most) +
                                            " fit in the rest of the file. Export or copy it again.");
    file_.limit_corners(corners, limits_);
  }

  void read_face(std::uint64_t index, std::uint64_t count) {
    require_record("faces", index, count);
    const std::size_t at = scan_.at();
    const std::uint64_t corners = scan_.count("the number of corners of a face");
    require_corners(corners, scan_.remaining() / 2 + 1, at);  // a digit and a blank each
    for (std::uint64_t k = 0; k < corners; ++k)
      file_.add_corner(static_cast<double>(scan_.count("the index of a vertex")), vertices_, at);
    file_.end_face(limits_);
    colored_faces_ += scan_.find_word_in_line();
    scan_.skip_line();
  }

  // The binary form: after the line "OFF BINARY", big-endian. Counts of vertices, faces and edges (32-bit integers), the values
  // of each vertex (floats; 4 for a colour), and of each face its corners' number and indices, its colour's number of values
  // (32-bit integers) and the values (floats).
  void read_binary() {
    scan_.skip_line();
    at_ = scan_.at();
    if (at_ < bytes_.size() && text_[at_] == '\r') ++at_;
    if (at_ < bytes_.size() && text_[at_] == '\n') ++at_;
    file_.places.text = false;
    if (vertex_.dimension) check_dimension(next_count("the dimension"));
    const std::uint64_t vertices = next_count("the number of vertices");
    const std::uint64_t faces = next_count("the number of faces");
    next_count("the number of edges");
    const std::uint64_t values = 3 + unsigned{vertex_.homogeneous} + 3 * unsigned{vertex_.normal} +
                                 4 * unsigned{vertex_.color} + 2 * unsigned{vertex_.uv};
    check_counts(vertices, 4 * values, faces, 8, bytes_.size() - at_);
    for (std::uint64_t v = 0; v < vertices; ++v) {
      const std::size_t vertex_at = at_;
      Vec3d p;
      for (int axis = 0; axis < 3; ++axis) p[axis] = next_float();
      add_vertex(p, vertex_.homogeneous ? next_float() : 1, vertex_at);
      if (vertex_.normal) {
        const float x = next_float(), y = next_float(), z = next_float();
        file_.normals.push_back({x, y, z});
      }
      if (vertex_.color) {
        std::array<double, 4> color{};
        for (double& c : color) c = next_float();
        add_color(color.data(), 4);
      }
      if (vertex_.uv) {
        const float u = next_float(), v_up = next_float();
        file_.uvs.push_back({u, v_up});
      }
    }
    for (std::uint64_t f = 0; f < faces; ++f) {
      const std::size_t face_at = at_;
      const std::uint64_t corners = next_count("the number of corners of a face");
      require_corners(corners, (bytes_.size() - at_) / 4, face_at);
      for (std::uint64_t k = 0; k < corners; ++k)
        file_.add_corner(static_cast<double>(next_count("the index of a vertex")), vertices_, face_at);
      file_.end_face(limits_);
      const std::uint64_t color = next_count("the colour of a face");
      require_bytes(4 * color, "the colour of a face");
      at_ += 4 * color;
      colored_faces_ += color > 0;
    }
  }

  void require_bytes(std::uint64_t count, const char* what) const {
    if (count <= bytes_.size() - at_) return;
    refuse(ErrorCode::kMalformedMesh, "The binary OFF file has " + std::to_string(bytes_.size()) +
                                          " bytes, but " + what + " at byte " + std::to_string(at_) +
                                          " needs " + std::to_string(count) +
                                          " more. It was cut short: export or copy it again.");
  }
  std::uint64_t next_count(const char* what) {
    require_bytes(4, what);
    const std::uint64_t value = unsigned_at(bytes_, at_, 4, ByteOrder::kBig);
    at_ += 4;
    return value;
  }
  /// check_counts() has established that the vertices fit into the file.
  float next_float() {
    const float value = float_at(bytes_, at_, ByteOrder::kBig);
    at_ += 4;
    return value;
  }

  static constexpr float kNoColor = -1e30f;

  std::span<const std::byte> bytes_;
  ImportLimits limits_;
  std::string_view text_;
  TextScanner scan_;
  std::size_t at_ = 0;  ///< in the binary form
  OffVertex vertex_;
  PolygonFile file_;
  std::uint64_t vertices_ = 0, colored_faces_ = 0;
  std::size_t uncolored_ = 0;
};

}  // namespace

Expected<Mesh> import_off(std::span<const std::byte> bytes, const ImportLimits& limits) {
  try {
    return finish_polygon_file(OffReader(bytes, limits).read(), limits);
  } catch (const Refused& refused) {
    return tl::unexpected<Error>(refused.error);
  }
}

}  // namespace fracture
