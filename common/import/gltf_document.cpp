#include "common/import/gltf_document.hpp"

#include <algorithm>
#include <iterator>
#include <optional>

#include "common/base/words.hpp"
#include "common/import/gltf_compression.hpp"
#include "common/import/gltf_dropped.hpp"
#include "common/import/gltf_extensions.hpp"
#include "common/import/gltf_materials.hpp"
#include "common/import/gltf_variants.hpp"
#include "common/import/limit_words.hpp"
#include "common/import/preflight.hpp"
#include "common/import/refused.hpp"
#include "common/import/uri.hpp"

namespace fracture {
namespace {

using nlohmann::json;

const json kEmptyArray = json::array();

/// Returns the array `object[key]`, empty if absent; refuses any other type.
const json& array_at(const json& object, const char* key, const std::string& pointer = {}) {
  const auto it = object.find(key);
  if (it == object.end()) return kEmptyArray;
  if (!it->is_array())
    refuse(ErrorCode::kMalformedMesh, std::string("\"") + key + "\" has to be an array.",
           pointer + "/" + key);
  return *it;
}

void require_objects(const json& document, const char* key) {
  const json& array = array_at(document, key);
  for (std::size_t k = 0; k < array.size(); ++k)
    if (!array[k].is_object())
      refuse(ErrorCode::kMalformedMesh,
             std::string("\"") + key + "\" contains a value that is not an object.",
             std::string("/") + key + "/" + std::to_string(k));
}

void check_version_and_extensions(const json& document) {
  const auto asset = document.find("asset");
  if (const auto meshes = document.find("meshes"); meshes != document.end() && meshes->is_object())
    refuse(
        ErrorCode::kUnsupportedFeature,
        "The document is glTF 1.0 (its \"meshes\" is an object, not an array); only glTF 2.x is supported.",
        "/meshes");
  if (asset == document.end() || !asset->is_object() || !asset->contains("version") ||
      !(*asset)["version"].is_string())
    refuse(ErrorCode::kMalformedMesh, "The document has no asset.version, so it is not glTF.",
           "/asset/version");
  const std::string version = (*asset)["version"].get<std::string>();
  if (version.substr(0, 2) != "2.")
    refuse(ErrorCode::kUnsupportedFeature,
           "The document is glTF " + version.substr(0, 16) + "; only glTF 2.x is supported.",
           "/asset/version");
  check_required_extensions(document);
}

/// The bytes of every buffer: the GLB's chunk, data uris, and files of the upload. No others exist.
class Buffers {
 public:
  Buffers(const json& document, std::span<const std::byte> glb_binary, bool is_glb,
          const ImportLimits& limits, std::span<const ImportFile> files) {
    const json& buffers = array_at(document, "buffers");
    std::uint64_t decoded = 0;
    // Check all uris before decoding any bytes.
    for (std::size_t k = 0; k < buffers.size(); ++k) {
      const auto uri = buffers[k].find("uri");
      if (uri == buffers[k].end()) continue;
      const std::string pointer = "/buffers/" + std::to_string(k) + "/uri";
      if (!uri->is_string()) refuse(ErrorCode::kMalformedMesh, "A uri has to be a string.", pointer);
      const auto& text = uri->get_ref<const std::string&>();
      if (!is_data_uri(text) && !find_file(files, text))
        refuse(ErrorCode::kExternalResource,
               "The buffer is in another file, \"" + text.substr(0, 80) +
                   "\", which was not given. Send a .glb, embed the buffer, send the file as another part of "
                   "the form, or, for bake, put it at the path that the mesh names.",
               pointer, {{"uri", text.substr(0, 200)}});
    }
    owned_.reserve(buffers.size());
    for (std::size_t k = 0; k < buffers.size(); ++k) {
      const std::string pointer = "/buffers/" + std::to_string(k);
      const std::uint64_t length = unsigned_at(buffers[k], "byteLength", kRequired, pointer);
      std::span<const std::uint8_t> bytes;
      bool absent = false;
      if (const auto uri = buffers[k].find("uri"); uri != buffers[k].end()) {
        const auto& text = uri->get_ref<const std::string&>();
        if (is_data_uri(text)) {
          auto data = decode_data_uri(text);
          if (!data) refuse(ErrorCode::kMalformedMesh, "The data uri is not valid base64.", pointer + "/uri");
          decoded += data->bytes.size();
          if (decoded > limits.max_decoded_bytes)
            refuse(ErrorCode::kTooLarge,
                   "The buffers up to this one decode to " + data_size(decoded) + "; the limit is " +
                       decoded_limit(limits.max_decoded_bytes) + ". " + kSmallerMesh,
                   pointer);
          owned_.push_back(std::move(data->bytes));
          bytes = owned_.back();
        } else {
          const ImportFile& file = *find_file(files, text);
          bytes = {reinterpret_cast<const std::uint8_t*>(file.bytes.data()), file.bytes.size()};
        }
      } else if (k == 0 && is_glb && !glb_binary.empty()) {
        bytes = {reinterpret_cast<const std::uint8_t*>(glb_binary.data()), glb_binary.size()};
      } else {
        absent = true;  // legal as the fallback of compressed views; reading it is refused below
      }
      if (!absent && length > bytes.size())
        refuse(ErrorCode::kMalformedMesh,
               "The buffer declares " + std::to_string(length) + " bytes but has " +
                   std::to_string(bytes.size()) + ".",
               pointer + "/byteLength");
      if (!absent) bytes = bytes.first(length);
      views_.push_back(absent ? std::nullopt : std::optional(bytes));
    }
  }

  /// Returns the bytes [offset, offset + length) of a buffer; refuses bytes that do not exist.
  std::span<const std::uint8_t> slice(std::uint64_t buffer, std::uint64_t offset, std::uint64_t length,
                                      const std::string& pointer) const {
    if (buffer >= views_.size())
      refuse(ErrorCode::kMalformedMesh, "Buffer " + std::to_string(buffer) + " does not exist.",
             pointer + "/buffer");
    if (!views_[buffer])
      refuse(ErrorCode::kMalformedMesh, "Buffer " + std::to_string(buffer) + " has no data.",
             pointer + "/buffer");
    const std::span<const std::uint8_t> bytes = *views_[buffer];
    if (offset > bytes.size() || length > bytes.size() - offset)
      refuse(ErrorCode::kMalformedMesh,
             "Buffer " + std::to_string(buffer) + " has only " + counted(bytes.size(), "byte", "bytes") +
                 ", so it cannot contain " + std::to_string(length) + " bytes from byte " +
                 std::to_string(offset) + " on.",
             pointer);
    return bytes.subspan(offset, length);
  }

 private:
  std::vector<std::vector<std::uint8_t>> owned_;
  std::vector<std::optional<std::span<const std::uint8_t>>> views_;
};

/// Marks the bufferViews that the geometry needs: those of accessors and of Draco primitives. Views of images
/// are not copied.
std::vector<bool> used_views(const json& document, std::size_t count) {
  std::vector<bool> used(count, false);
  const auto mark = [&](const json& object) {
    const auto it = object.find("bufferView");
    if (it == object.end() || !it->is_number_unsigned()) return;
    if (const auto view = it->get<std::uint64_t>(); view < count) used[view] = true;
  };
  for (const json& accessor : array_at(document, "accessors")) {
    mark(accessor);
    if (const auto sparse = accessor.find("sparse"); sparse != accessor.end() && sparse->is_object())
      for (const char* part : {"indices", "values"})
        if (const auto it = sparse->find(part); it != sparse->end() && it->is_object()) mark(*it);
  }
  for (const json& mesh : array_at(document, "meshes"))
    for (const json& primitive : array_at(mesh, "primitives")) {
      if (!primitive.is_object())
        refuse(ErrorCode::kMalformedMesh, "A primitive has to be an object.", "/meshes");
      if (const auto extensions = primitive.find("extensions");
          extensions != primitive.end() && extensions->is_object())
        if (const auto draco = extensions->find("KHR_draco_mesh_compression");
            draco != extensions->end() && draco->is_object())
          mark(*draco);
    }
  return used;
}

/// Copies (or decodes) every needed view into one buffer, and redirects it there.
void gather_views(GltfDocument& document, const Buffers& buffers, const ImportLimits& limits) {
  const std::vector<bool> used = used_views(document.json, array_at(document.json, "bufferViews").size());
  json views = json::array();
  const json& sources = array_at(document.json, "bufferViews");
  for (std::size_t k = 0; k < sources.size(); ++k) {
    const std::string pointer = "/bufferViews/" + std::to_string(k);
    const json& source = sources[k];
    const std::uint64_t stride = unsigned_at(source, "byteStride", 0, pointer);
    if (source.contains("byteStride") && (stride < 4 || stride > 252 || stride % 4 != 0))
      refuse(ErrorCode::kMalformedMesh,
             "byteStride has to be a multiple of 4 from 4 to 252, not " + std::to_string(stride) + ".",
             pointer + "/byteStride");
    const std::uint64_t length = unsigned_at(source, "byteLength", kRequired, pointer);
    const auto [name, meshopt] = meshopt_view(source);
    json view = {{"buffer", 0}, {"byteOffset", 0}, {"byteLength", length}};
    if (stride != 0) view["byteStride"] = stride;
    if (meshopt != nullptr) {
      const std::string inner = pointer + "/extensions/" + name;
      const auto packed = buffers.slice(unsigned_at(*meshopt, "buffer", kRequired, inner),
                                        unsigned_at(*meshopt, "byteOffset", 0, inner),
                                        unsigned_at(*meshopt, "byteLength", kRequired, inner), inner);
      if (used[k]) {
        const std::vector<std::uint8_t> plain = decode_meshopt(*meshopt, packed, limits, inner);
        if (plain.size() < length)
          refuse(ErrorCode::kMalformedMesh,
                 "The compressed view decodes to " + std::to_string(plain.size()) + " bytes, but declares " +
                     std::to_string(length) + ".",
                 pointer + "/byteLength");
        view["byteOffset"] = append_binary(document, plain, limits);
      }
    } else {
      const auto bytes = buffers.slice(unsigned_at(source, "buffer", kRequired, pointer),
                                       unsigned_at(source, "byteOffset", 0, pointer), length, pointer);
      if (used[k]) view["byteOffset"] = append_binary(document, bytes, limits);
    }
    views.push_back(std::move(view));
  }
  document.json["bufferViews"] = std::move(views);
}

/// Checks that elements [0, count) of `element` bytes at `offset`, `stride` apart, are in a view, in 64 bits.
void check_range(const json& document, std::uint64_t view, std::uint64_t offset, std::uint64_t count,
                 std::uint64_t element, bool may_stride, const std::string& pointer) {
  const json& views = array_at(document, "bufferViews");
  if (view >= views.size())
    refuse(ErrorCode::kMalformedMesh, "bufferView " + std::to_string(view) + " does not exist.",
           pointer + "/bufferView");
  const std::uint64_t length = views[view]["byteLength"].get<std::uint64_t>();
  std::uint64_t stride = may_stride ? views[view].value("byteStride", std::uint64_t{0}) : 0;
  if (stride == 0) stride = element;
  if (stride < element)
    refuse(ErrorCode::kMalformedMesh, "The view's byteStride is smaller than an element.", pointer);
  // offset + (count - 1) * stride + element <= length, without overflow: stride <= 252, and a division
  // replaces the multiplication
  const bool fits =
      offset <= length && element <= length - offset && (count - 1) <= (length - offset - element) / stride;
  if (!fits)
    refuse(ErrorCode::kMalformedMesh,
           std::to_string(count) + " elements of " + std::to_string(element) +
               " bytes each do not fit in bufferView " + std::to_string(view) + ", which has " +
               std::to_string(length) + " bytes.",
           pointer, {{"count", count}, {"byte_length", length}});
}

void check_accessors(const json& document, const ImportLimits& limits) {
  const json& accessors = array_at(document, "accessors");
  for (std::size_t k = 0; k < accessors.size(); ++k) {
    const std::string pointer = "/accessors/" + std::to_string(k);
    const json& accessor = accessors[k];
    const std::uint64_t component =
        component_bytes(unsigned_at(accessor, "componentType", kRequired, pointer));
    if (component == 0)
      refuse(ErrorCode::kMalformedMesh, "The componentType is unknown.", pointer + "/componentType");
    const auto type = accessor.find("type");
    const std::uint64_t components =
        type != accessor.end() && type->is_string() ? component_count(type->get<std::string>()) : 0;
    if (components == 0)
      refuse(ErrorCode::kMalformedMesh, "The accessor's type is unknown.", pointer + "/type");
    const std::uint64_t count = unsigned_at(accessor, "count", kRequired, pointer);
    if (count == 0)
      refuse(ErrorCode::kMalformedMesh, "An accessor needs at least one element.", pointer + "/count");
    const std::uint64_t element = component * components;
    if (count > limits.max_decoded_bytes / element)
      refuse(ErrorCode::kTooLarge,
             "The accessor declares " + grouped(count) + " elements of " + std::to_string(element) +
                 " bytes; the limit for a mesh is " + decoded_limit(limits.max_decoded_bytes) + ". " +
                 kSmallerMesh,
             pointer + "/count", {{"count", count}});
    if (accessor.contains("bufferView"))
      check_range(document, unsigned_at(accessor, "bufferView", kRequired, pointer),
                  unsigned_at(accessor, "byteOffset", 0, pointer), count, element, true, pointer);
    if (const auto sparse = accessor.find("sparse"); sparse != accessor.end()) {
      const std::string inner = pointer + "/sparse";
      if (!sparse->is_object() || !sparse->contains("indices") || !(*sparse)["indices"].is_object() ||
          !sparse->contains("values") || !(*sparse)["values"].is_object())
        refuse(ErrorCode::kMalformedMesh, "A sparse accessor needs indices and values.", inner);
      const std::uint64_t changed = unsigned_at(*sparse, "count", kRequired, inner);
      if (changed == 0 || changed > count)
        refuse(ErrorCode::kMalformedMesh, "The sparse count has to be between 1 and the accessor's count.",
               inner + "/count");
      const json &indices = (*sparse)["indices"], &values = (*sparse)["values"];
      const std::uint64_t index_type = unsigned_at(indices, "componentType", kRequired, inner + "/indices");
      if (!is_index_type(index_type))
        refuse(ErrorCode::kMalformedMesh, "Sparse indices have to be unsigned integers.",
               inner + "/indices/componentType");
      check_range(document, unsigned_at(indices, "bufferView", kRequired, inner + "/indices"),
                  unsigned_at(indices, "byteOffset", 0, inner + "/indices"), changed,
                  component_bytes(index_type), false, inner + "/indices");
      check_range(document, unsigned_at(values, "bufferView", kRequired, inner + "/values"),
                  unsigned_at(values, "byteOffset", 0, inner + "/values"), changed, element, false,
                  inner + "/values");
    }
  }
}

json parse(std::string_view text, const ImportLimits& limits) {
  if (auto depth = preflight::check_json_depth(text, limits.max_json_depth); !depth)
    throw Refused{depth.error()};
  while (!text.empty() && (text.back() == '\0' || text.back() == ' '))
    text.remove_suffix(1);  // chunk padding
  try {
    json document = json::parse(text);
    if (!document.is_object()) refuse(ErrorCode::kMalformedMesh, "The JSON of the glTF is not an object.");
    return document;
  } catch (const json::parse_error& error) {
    std::string beginning;
    for (const char c : text.substr(0, 16)) beginning += c >= 0x20 && c < 0x7f ? c : '.';
    refuse(ErrorCode::kMalformedMesh,
           (error.byte > text.size()
                ? "The JSON of the glTF ends at byte " + grouped(error.byte) + ", before it is complete"
                : "The JSON of the glTF is not valid at byte " + grouped(error.byte)) +
               "; the JSON begins with \"" + beginning + "\". Copy, download or export the file again.",
           {}, {{"byte", error.byte}});
  }
}

/// CESIUM_RTC: the place of the scene's origin, in the coordinates of the scene.
Vec3d center_of(const json& document) {
  const auto extensions = document.find("extensions");
  if (extensions == document.end() || !extensions->is_object() || !extensions->contains("CESIUM_RTC"))
    return {};
  const json& extension = (*extensions)["CESIUM_RTC"];
  const auto center = extension.is_object() ? extension.find("center") : extension.end();
  if (center == extension.end() || !center->is_array() || center->size() != 3 ||
      !std::all_of(center->begin(), center->end(), [](const json& c) { return c.is_number(); }))
    refuse(ErrorCode::kMalformedMesh, "The center of CESIUM_RTC has to be three numbers.",
           "/extensions/CESIUM_RTC/center");
  return {(*center)[0].get<double>(), (*center)[1].get<double>(), (*center)[2].get<double>()};
}

}  // namespace

std::uint64_t unsigned_at(const json& object, const char* key, std::uint64_t fallback,
                          const std::string& pointer) {
  const auto it = object.find(key);
  if (it == object.end()) {
    if (fallback == kRequired)
      refuse(ErrorCode::kMalformedMesh, std::string("\"") + key + "\" is missing.", pointer + "/" + key);
    return fallback;
  }
  if (it->is_number_unsigned()) return it->get<std::uint64_t>();
  // Some exporters write 12.0 instead of 12.
  if (it->is_number_float() && it->get<double>() >= 0 && it->get<double>() < 0x1p53 &&
      it->get<double>() == static_cast<double>(static_cast<std::uint64_t>(it->get<double>())))
    return static_cast<std::uint64_t>(it->get<double>());
  refuse(ErrorCode::kMalformedMesh, std::string("\"") + key + "\" has to be a non-negative integer.",
         pointer + "/" + key);
}

std::uint64_t component_count(const std::string& type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4" || type == "MAT2") return 4;
  if (type == "MAT3") return 9;
  return type == "MAT4" ? 16 : 0;
}

std::uint64_t append_binary(GltfDocument& document, std::span<const std::uint8_t> bytes,
                            const ImportLimits& limits) {
  const std::uint64_t offset = (document.binary.size() + 7) / 8 * 8;
  if (bytes.size() > limits.max_decoded_bytes || offset > limits.max_decoded_bytes - bytes.size())
    refuse(ErrorCode::kTooLarge, "The decoded geometry is larger than the limit of " +
                                     decoded_limit(limits.max_decoded_bytes) + ". " + kSmallerMesh);
  document.binary.resize(offset);
  document.binary.insert(document.binary.end(), bytes.begin(), bytes.end());
  return offset;
}

GltfDocument read_gltf_document(std::span<const std::byte> bytes, MeshFormat format,
                                const ImportLimits& limits, std::span<const ImportFile> files) {
  GltfDocument document;
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::span<const std::byte> glb_binary;
  if (format == MeshFormat::kGlb) {
    auto chunks = preflight::split_glb(bytes);
    if (!chunks) throw Refused{chunks.error()};
    text = chunks->json;
    glb_binary = chunks->binary;
  } else if (text.substr(0, 4) == "glTF") {
    refuse(ErrorCode::kMalformedMesh, "This is a binary glTF: send it as format glb (model/gltf-binary).");
  }
  document.json = parse(text, limits);
  check_version_and_extensions(document.json);
  for (const char* key : {"buffers", "bufferViews", "accessors", "meshes", "nodes", "scenes", "skins",
                          "images", "textures", "materials", "samplers", "animations"})
    require_objects(document.json, key);
  const Buffers buffers(document.json, glb_binary, format == MeshFormat::kGlb, limits, files);
  const auto view_bytes = [&](std::uint64_t view, const std::string& pointer) {
    const json& views = array_at(document.json, "bufferViews");
    if (view >= views.size())
      refuse(ErrorCode::kMalformedMesh, "bufferView " + std::to_string(view) + " does not exist.", pointer);
    return buffers.slice(unsigned_at(views[view], "buffer", kRequired, pointer),
                         unsigned_at(views[view], "byteOffset", 0, pointer),
                         unsigned_at(views[view], "byteLength", kRequired, pointer), pointer);
  };
  std::vector<Dropped> looks;
  document.library = read_materials(document.json, view_bytes, files, document.remarks, looks);
  if (document.json["asset"].contains("copyright") && document.json["asset"]["copyright"].is_string())
    document.copyright = document.json["asset"]["copyright"].get<std::string>();
  document.dropped = dropped_from(document.json);
  std::ranges::move(looks, std::back_inserter(document.dropped));
  read_variants(document.json, document.library, document.dropped);
  document.center = center_of(document.json);

  gather_views(document, buffers, limits);
  check_accessors(document.json, limits);
  decode_draco_primitives(document, limits);

  for (const char* key : {"images", "textures", "materials", "samplers", "animations", "cameras",
                          "extensions", "extras", "extensionsUsed", "extensionsRequired"})
    document.json.erase(key);
  document.json["asset"] = {{"version", "2.0"}};
  document.json.erase("buffers");
  if (document.binary.empty()) document.binary.resize(4);
  document.binary.resize((document.binary.size() + 3) / 4 * 4);
  document.json["buffers"] = json::array({{{"byteLength", document.binary.size()}}});
  return document;
}

}  // namespace fracture
