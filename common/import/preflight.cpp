#include "common/import/preflight.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace fracture::preflight {
namespace {

std::uint32_t read_u32(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (int k = 3; k >= 0; --k) value = value << 8 | std::to_integer<std::uint32_t>(bytes[at + k]);
  return value;
}

std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The first bytes, printable, for error messages about files that are not in the declared format.
std::string beginning_of(std::span<const std::byte> bytes) {
  std::string shown;
  for (const char c : as_text(bytes.first(std::min<std::size_t>(bytes.size(), 16))))
    shown += c >= 0x20 && c < 0x7f ? c : '.';
  return "\"" + shown + "\"";
}

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f'; }

/// Reads words separated by white space; comments extend from # to the end of the line.
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) {}

  std::string_view next() {
    while (at_ < text_.size()) {
      if (is_space(text_[at_])) {
        ++at_;
      } else if (text_[at_] == '#') {
        while (at_ < text_.size() && text_[at_] != '\n') ++at_;
      } else {
        break;
      }
    }
    const std::size_t begin = at_;
    while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }
  std::size_t remaining() const { return text_.size() - at_; }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
};

bool parse_count(std::string_view word, std::uint64_t& value) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc{} && end == word.data() + word.size();
}

tl::unexpected<Error> too_many_triangles(std::uint64_t count, const ImportLimits& limits) {
  return fail(ErrorCode::kTooLarge,
              "The file has at least " + std::to_string(count) + " faces; the limit is " +
                  std::to_string(limits.max_triangles) + " triangles.",
              {}, {{"triangles", count}, {"limit", limits.max_triangles}});
}

}  // namespace

Expected<GlbChunks> split_glb(std::span<const std::byte> bytes) {
  constexpr std::uint32_t kMagic = 0x46546c67, kJson = 0x4e4f534a, kBin = 0x004e4942;
  if (bytes.size() < 4 || read_u32(bytes, 0) != kMagic) {
    const std::string_view text = as_text(bytes);
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    const bool json = first != std::string_view::npos && text[first] == '{';
    return fail(ErrorCode::kMalformedMesh,
                "This is not a GLB file: it has to begin with \"glTF\" but begins with " +
                    beginning_of(bytes) + "." +
                    (json ? " It looks like JSON: send it as format gltf (model/gltf+json)." : ""));
  }
  if (bytes.size() < 20)
    return fail(ErrorCode::kMalformedMesh, "The GLB is truncated: " + std::to_string(bytes.size()) +
                                               " bytes cannot hold its header and first chunk (20 bytes).");
  if (const std::uint32_t version = read_u32(bytes, 4); version != 2)
    return fail(ErrorCode::kUnsupportedFeature, "The GLB has container version " + std::to_string(version) +
                                                    "; only version 2 (glTF 2.0) is supported.");
  const std::uint64_t length = read_u32(bytes, 8);
  if (length > bytes.size())
    return fail(ErrorCode::kMalformedMesh, "The GLB is truncated: its header at byte 8 declares " +
                                               std::to_string(length) + " bytes, but only " +
                                               std::to_string(bytes.size()) + " arrived.");
  GlbChunks chunks;
  bool have_json = false, have_bin = false;
  for (std::uint64_t at = 12; at + 8 <= length;) {
    const std::uint64_t size = read_u32(bytes, at);
    const std::uint32_t type = read_u32(bytes, at + 4);
    if (size > length - at - 8)
      return fail(ErrorCode::kMalformedMesh, "The GLB chunk at byte " + std::to_string(at) + " declares " +
                                                 std::to_string(size) + " bytes, more than the " +
                                                 std::to_string(length - at - 8) + " that follow.");
    const auto body = bytes.subspan(at + 8, size);
    if (at == 12) {
      if (type != kJson)
        return fail(ErrorCode::kMalformedMesh, "The first chunk of the GLB (byte 12) is not JSON.");
      chunks.json = as_text(body);
      have_json = true;
    } else if (type == kBin && !have_bin) {
      chunks.binary = body;
      have_bin = true;
    }
    at += 8 + size;
  }
  if (!have_json) return fail(ErrorCode::kMalformedMesh, "The GLB has no JSON chunk.");
  return chunks;
}

Expected<void> check_json_depth(std::string_view json, std::uint32_t max_depth) {
  std::uint32_t depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string) {
      if (c == '\\')
        ++i;
      else if (c == '"')
        in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      if (++depth > max_depth)
        return fail(ErrorCode::kMalformedMesh, "The JSON is nested deeper than " + std::to_string(max_depth) +
                                                   " levels at byte " + std::to_string(i) + ".");
    } else if ((c == '}' || c == ']') && depth > 0) {
      --depth;
    }
  }
  return {};
}

Expected<void> check_stl(std::span<const std::byte> bytes, const ImportLimits& limits) {
  const std::string_view text = as_text(bytes);
  if (bytes.size() >= 84) {
    const std::uint64_t count = read_u32(bytes, 80);
    const std::uint64_t needed = 84 + 50 * count;
    if (needed == bytes.size()) {
      if (count == 0) return fail(ErrorCode::kEmptyMesh, "The binary STL declares 0 triangles.");
      if (count > limits.max_triangles) return too_many_triangles(count, limits);
      return {};
    }
  }
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  const bool ascii = first != std::string_view::npos && text.substr(first, 5) == "solid";
  // A binary file may begin with "solid" in its free 80-byte header. Unlike an ASCII file, it does not contain
  // "facet".
  if (ascii && text.find("facet") != std::string_view::npos) {
    if (text.find('\0') != std::string_view::npos)
      return fail(ErrorCode::kMalformedMesh,
                  "The ASCII STL contains a zero at byte " + std::to_string(text.find('\0')) + ".");
    std::uint64_t facets = 0;
    for (std::size_t at = text.find("outer"); at != std::string_view::npos; at = text.find("outer", at + 5))
      ++facets;
    if (facets == 0) return fail(ErrorCode::kEmptyMesh, "The ASCII STL has no facet with an outer loop.");
    if (facets > limits.max_triangles) return too_many_triangles(facets, limits);
    return {};
  }
  if (ascii && text.find("endsolid") != std::string_view::npos)
    return fail(ErrorCode::kEmptyMesh, "The ASCII STL has no facets.");
  if (bytes.size() < 84)
    return fail(ErrorCode::kMalformedMesh,
                "This is not an STL file: its " + std::to_string(bytes.size()) +
                    " bytes contain neither an ASCII \"solid\" nor a binary header (84 bytes).");
  const std::uint64_t count = read_u32(bytes, 80);
  return fail(ErrorCode::kMalformedMesh,
              "The binary STL declares " + std::to_string(count) + " triangles at byte 80, so it must have " +
                  std::to_string(84 + 50 * count) + " bytes; " + std::to_string(bytes.size()) + " arrived.");
}

Expected<void> check_ply(std::span<const std::byte> bytes, const ImportLimits& limits) {
  const std::string_view text = as_text(bytes);
  if (text.substr(0, 3) != "ply" || text.size() < 4 || (text[3] != '\n' && text[3] != '\r'))
    return fail(ErrorCode::kMalformedMesh,
                "This is not a PLY file: it has to begin with a line \"ply\" but begins with " +
                    beginning_of(bytes) + ".");
  struct Element {
    std::string name;
    std::uint64_t count = 0, bytes_each = 0, words_each = 0;
  };
  std::vector<Element> elements;
  bool ascii = false, have_format = false, ended = false;
  std::size_t at = 0;
  const auto size_of = [](std::string_view type) -> std::uint64_t {
    if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
    if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
    if (type == "int" || type == "uint" || type == "int32" || type == "uint32" || type == "float" ||
        type == "float32")
      return 4;
    return type == "double" || type == "float64" ? 8 : 0;
  };
  constexpr std::size_t kMaxHeader = 64 * 1024;
  while (!ended && at < text.size() && at < kMaxHeader) {
    const std::size_t line_at = at;
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = text.substr(at, end - at);
    at = std::min(end + 1, text.size());
    Words words(line);
    const std::string_view keyword = words.next();
    const auto bad = [&](const char* what) {
      return fail(ErrorCode::kMalformedMesh,
                  std::string("The PLY header ") + what + " at byte " + std::to_string(line_at) + ".");
    };
    if (keyword == "format") {
      const std::string_view format = words.next();
      have_format = true;
      ascii = format == "ascii";
      if (!ascii && format != "binary_little_endian" && format != "binary_big_endian")
        return bad("names an unknown format");
    } else if (keyword == "element") {
      Element element;
      element.name = words.next();
      if (!parse_count(words.next(), element.count)) return bad("has an element without a count");
      elements.push_back(element);
    } else if (keyword == "property") {
      if (elements.empty()) return bad("has a property before any element");
      std::string_view type = words.next();
      if (type == "list") type = words.next();  // an empty list has only its count
      const std::uint64_t size = size_of(type);
      if (size == 0) return bad("has a property of unknown type");
      elements.back().bytes_each += size;
      elements.back().words_each += 1;
    } else if (keyword == "end_header") {
      ended = true;
    }
  }
  if (!ended) return fail(ErrorCode::kMalformedMesh, "The PLY has no end_header line.");
  if (!have_format) return fail(ErrorCode::kMalformedMesh, "The PLY header has no format line.");
  std::uint64_t remaining = text.size() - at;
  bool faces = false;
  for (const Element& element : elements) {
    // ASCII: one word and one separator per value (the last separator may be missing).
    const std::uint64_t each =
        std::max<std::uint64_t>(1, ascii ? 2 * element.words_each : element.bytes_each);
    if (element.count > (remaining + 1) / each)
      return fail(ErrorCode::kMalformedMesh,
                  "The PLY declares " + std::to_string(element.count) + " elements \"" +
                      element.name.substr(0, 40) + "\" (at least " + std::to_string(each) +
                      " bytes each), but only " + std::to_string(remaining) + " bytes follow.");
    remaining -= std::min(remaining, element.count * each);
    if ((element.name == "face" || element.name == "tristrips") && element.count > 0) {
      faces = true;
      if (element.count > limits.max_triangles) return too_many_triangles(element.count, limits);
    }
  }
  if (!faces)
    return fail(ErrorCode::kEmptyMesh, "The PLY declares no faces: a point cloud encloses no volume.");
  return {};
}

Expected<void> check_off(std::span<const std::byte> bytes, const ImportLimits& limits) {
  const std::string_view text = as_text(bytes);
  if (text.find('\0') != std::string_view::npos)
    return fail(ErrorCode::kMalformedMesh, "The OFF file contains a zero at byte " +
                                               std::to_string(text.find('\0')) +
                                               "; only text files are supported.");
  Words words(text);
  const std::string_view magic = words.next();
  if (magic.size() > 8 || magic.find("OFF") == std::string_view::npos)
    return fail(
        ErrorCode::kMalformedMesh,
        "This is not an OFF file: it has to begin with \"OFF\" but begins with " + beginning_of(bytes) + ".");
  std::uint64_t vertices = 0, faces = 0, edges = 0;
  if (!parse_count(words.next(), vertices) || !parse_count(words.next(), faces) ||
      !parse_count(words.next(), edges))
    return fail(ErrorCode::kMalformedMesh,
                "The OFF header does not contain three counts (vertices, faces, edges).");
  constexpr std::uint64_t kVertexBytes = 6,
                          kFaceBytes = 2;  // "0 0 0\n" and, for a face without corners, "0\n"
  const std::uint64_t remaining = words.remaining() + 1;
  if (vertices > remaining / kVertexBytes || faces > remaining / kFaceBytes ||
      vertices * kVertexBytes + faces * kFaceBytes > remaining)
    return fail(ErrorCode::kMalformedMesh, "The OFF header declares " + std::to_string(vertices) +
                                               " vertices and " + std::to_string(faces) +
                                               " faces, but only " + std::to_string(words.remaining()) +
                                               " bytes follow.");
  if (faces == 0) return fail(ErrorCode::kEmptyMesh, "The OFF file declares no faces.");
  if (faces > limits.max_triangles) return too_many_triangles(faces, limits);
  return {};
}

Expected<void> check_magic(std::span<const std::byte> bytes, MeshFormat format) {
  const std::string_view text = as_text(bytes);
  const auto begins = [&](std::string_view magic) { return text.substr(0, magic.size()) == magic; };
  const auto refuse = [&](const char* name, const char* expected) {
    return fail(ErrorCode::kMalformedMesh, std::string("This is not a ") + name + " file: expected " +
                                               expected + ", found " + beginning_of(bytes) + ".");
  };
  switch (format) {
    case MeshFormat::kBlend:
      if (!begins("BLENDER")) return refuse("BLEND", "\"BLENDER\" at the beginning");
      return {};
    case MeshFormat::kFbx:
      if (!begins("Kaydara FBX Binary") && text.substr(0, 4096).find("FBX") == std::string_view::npos)
        return refuse("FBX", "\"Kaydara FBX Binary\" or an ASCII FBX header");
      return {};
    case MeshFormat::kDae:
      if (text.substr(0, 65536).find("<COLLADA") == std::string_view::npos)
        return refuse("COLLADA", "a <COLLADA> element");
      return {};
    case MeshFormat::k3ds:
      if (!begins("MM") || bytes.size() < 6 || read_u32(bytes, 2) > bytes.size())
        return refuse("3DS", "a main chunk \"MM\" that fits in the file");
      return {};
    default:
      return {};
  }
}

}  // namespace fracture::preflight
