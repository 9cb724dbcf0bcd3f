#include "common/import/gltf_compression.hpp"

#include <draco/compression/decode.h>
#include <meshoptimizer.h>

#include <cstring>
#include <map>

#include "common/base/words.hpp"
#include "common/import/limit_words.hpp"
#include "common/import/refused.hpp"

namespace fracture {
namespace {

using nlohmann::json;

template <class T>
void convert_attribute(const draco::PointAttribute& attribute, std::uint32_t points, int components,
                       std::vector<std::uint8_t>& out, const std::string& pointer) {
  std::vector<T> values(components);
  out.resize(std::size_t{points} * components * sizeof(T));
  for (std::uint32_t p = 0; p < points; ++p) {
    const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(p));
    if (value.value() >= attribute.size() ||
        !attribute.ConvertValue<T>(value, static_cast<std::int8_t>(components), values.data()))
      refuse(ErrorCode::kMalformedMesh, "The Draco data cannot be converted to the accessor's type.",
             pointer);
    std::memcpy(&out[std::size_t{p} * components * sizeof(T)], values.data(), components * sizeof(T));
  }
}

std::vector<std::uint8_t> attribute_bytes(const draco::PointAttribute& attribute, std::uint32_t points,
                                          std::uint64_t type, int components, const std::string& pointer) {
  std::vector<std::uint8_t> out;
  switch (type) {
    case component_type::kByte:
      convert_attribute<std::int8_t>(attribute, points, components, out, pointer);
      break;
    case component_type::kUnsignedByte:
      convert_attribute<std::uint8_t>(attribute, points, components, out, pointer);
      break;
    case component_type::kShort:
      convert_attribute<std::int16_t>(attribute, points, components, out, pointer);
      break;
    case component_type::kUnsignedShort:
      convert_attribute<std::uint16_t>(attribute, points, components, out, pointer);
      break;
    case component_type::kUnsignedInt:
      convert_attribute<std::uint32_t>(attribute, points, components, out, pointer);
      break;
    default:
      convert_attribute<float>(attribute, points, components, out, pointer);
      break;
  }
  return out;
}

/// Adds a view over the bytes, and an accessor for it that is like `like`. Returns the index of the accessor.
std::uint64_t add_accessor(GltfDocument& document, const json& like, std::span<const std::uint8_t> bytes,
                           std::uint64_t count, const ImportLimits& limits) {
  const std::uint64_t offset = append_binary(document, bytes, limits);
  json& views = document.json["bufferViews"];
  views.push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes.size()}});
  json accessor = {{"bufferView", views.size() - 1},
                   {"componentType", like.at("componentType")},
                   {"count", count},
                   {"type", like.at("type")}};
  if (like.contains("normalized")) accessor["normalized"] = like["normalized"];
  json& accessors = document.json["accessors"];
  accessors.push_back(std::move(accessor));
  return accessors.size() - 1;
}

void decode_primitive(GltfDocument& document, json& primitive, const ImportLimits& limits,
                      const std::string& pointer) {
  const json extension = primitive["extensions"]["KHR_draco_mesh_compression"];
  primitive["extensions"].erase("KHR_draco_mesh_compression");
  const std::string inner = pointer + "/extensions/KHR_draco_mesh_compression";
  const std::uint64_t view = unsigned_at(extension, "bufferView", kRequired, inner);
  if (!document.json.contains("bufferViews") || view >= document.json["bufferViews"].size())
    refuse(ErrorCode::kMalformedMesh, "The Draco data's bufferView does not exist.", inner + "/bufferView");
  const json& span = document.json["bufferViews"][view];
  const auto offset = span.at("byteOffset").get<std::uint64_t>(),
             length = span.at("byteLength").get<std::uint64_t>();
  // The buffer grows while decoded data is appended, so the packed bytes are copied first.
  const std::vector<char> packed(document.binary.begin() + static_cast<std::ptrdiff_t>(offset),
                                 document.binary.begin() + static_cast<std::ptrdiff_t>(offset + length));
  draco::DecoderBuffer buffer;
  buffer.Init(packed.data(), packed.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok())
    refuse(ErrorCode::kMalformedMesh,
           "The Draco data cannot be decoded: " + decoded.status().error_msg_string() + ".", inner);
  const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
  const std::uint32_t points = mesh->num_points();
  const std::uint64_t faces = mesh->num_faces();
  if (faces > limits.max_triangles)
    refuse(ErrorCode::kTooLarge,
           "The Draco data has " + counted(faces, "triangle", "triangles") + "; the limit is " +
               triangle_limit(limits.max_triangles) + ". " + kSmallerMesh,
           inner);
  if (faces == 0 || points == 0) refuse(ErrorCode::kMalformedMesh, "The Draco data has no triangles.", inner);

  std::vector<std::uint8_t> indices(faces * 12);
  for (std::uint64_t f = 0; f < faces; ++f) {
    const draco::Mesh::Face& face = mesh->face(draco::FaceIndex(static_cast<std::uint32_t>(f)));
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t index = face[k].value();
      if (index >= points)
        refuse(ErrorCode::kMalformedMesh, "A Draco triangle refers to a point that does not exist.", inner);
      std::memcpy(&indices[f * 12 + k * 4], &index, 4);
    }
  }
  primitive["indices"] =
      add_accessor(document, {{"componentType", component_type::kUnsignedInt}, {"type", "SCALAR"}}, indices,
                   faces * 3, limits);
  primitive["mode"] = 4;  // Draco contains triangles, regardless of the mode given to the encoder

  const auto wanted = extension.find("attributes");
  if (wanted == extension.end() || !wanted->is_object() || !primitive.contains("attributes") ||
      !primitive["attributes"].is_object())
    refuse(ErrorCode::kMalformedMesh, "The Draco primitive has no attributes.", inner + "/attributes");
  json attributes = json::object();
  for (const auto& [name, id] : wanted->items()) {
    if (!id.is_number_unsigned() || !primitive["attributes"].contains(name)) continue;
    const std::uint64_t accessor =
        unsigned_at(primitive["attributes"], name.c_str(), kRequired, pointer + "/attributes");
    if (accessor >= document.json["accessors"].size())
      refuse(ErrorCode::kMalformedMesh, "Accessor " + std::to_string(accessor) + " does not exist.",
             pointer + "/attributes/" + name);
    const json like = document.json["accessors"][accessor];
    const draco::PointAttribute* attribute = mesh->GetAttributeByUniqueId(id.get<std::uint32_t>());
    if (attribute == nullptr)
      refuse(ErrorCode::kMalformedMesh, "The Draco data has no attribute " + id.dump() + ".",
             inner + "/attributes/" + name);
    const int components = static_cast<int>(component_count(like.at("type").get<std::string>()));
    const auto bytes =
        attribute_bytes(*attribute, points, like.at("componentType").get<std::uint64_t>(), components, inner);
    attributes[name] = add_accessor(document, like, bytes, points, limits);
  }
  primitive["attributes"] = std::move(attributes);
}

}  // namespace

std::vector<std::uint8_t> decode_meshopt(const json& extension, std::span<const std::uint8_t> source,
                                         const ImportLimits& limits, const std::string& pointer) {
  const std::uint64_t stride = unsigned_at(extension, "byteStride", kRequired, pointer);
  const std::uint64_t count = unsigned_at(extension, "count", kRequired, pointer);
  const auto text_at = [&](const char* key, const char* fallback) {
    const auto it = extension.find(key);
    return it != extension.end() && it->is_string() ? it->get<std::string>() : std::string(fallback);
  };
  const std::string mode = text_at("mode", ""), filter = text_at("filter", "NONE");
  if (stride == 0 || stride > 256 || count == 0 || count > limits.max_decoded_bytes / stride)
    refuse(ErrorCode::kTooLarge,
           "The compressed view declares " + counted(count, "element", "elements") + " of " +
               std::to_string(stride) +
               " bytes. It needs at least one element, elements of 1 to 256 bytes, and at most " +
               decoded_limit(limits.max_decoded_bytes) + " in total. Export the file again.",
           pointer);
  std::vector<std::uint8_t> out(count * stride);
  int result = -1;
  if (mode == "ATTRIBUTES") {
    if (stride % 4 != 0)
      refuse(ErrorCode::kMalformedMesh, "The byteStride has to be a multiple of 4.", pointer + "/byteStride");
    // The first byte is the codec's number and its version.
    if (!source.empty() && source[0] == 0xa1)
      refuse(
          ErrorCode::kUnsupportedFeature,
          "The compressed view has version 1 of the vertex codec; only version 0 is supported. Compress the "
          "file with EXT_meshopt_compression.",
          pointer);
    result = meshopt_decodeVertexBuffer(out.data(), count, stride, source.data(), source.size());
  } else if (mode == "TRIANGLES" || mode == "INDICES") {
    if ((stride != 2 && stride != 4) || (mode == "TRIANGLES" && count % 3 != 0))
      refuse(ErrorCode::kMalformedMesh,
             "Each compressed index must have 2 or 4 bytes, and each triangle must have three indices.",
             pointer);
    result = mode == "TRIANGLES"
                 ? meshopt_decodeIndexBuffer(out.data(), count, stride, source.data(), source.size())
                 : meshopt_decodeIndexSequence(out.data(), count, stride, source.data(), source.size());
  } else {
    refuse(ErrorCode::kUnsupportedFeature,
           "The compression mode \"" + mode.substr(0, 40) + "\" is not supported.", pointer + "/mode");
  }
  if (result != 0) refuse(ErrorCode::kMalformedMesh, "The meshopt data cannot be decoded.", pointer);
  if (filter != "NONE") {
    const bool octahedral = filter == "OCTAHEDRAL" && (stride == 4 || stride == 8);
    const bool quaternion = filter == "QUATERNION" && stride == 8;
    const bool exponential = filter == "EXPONENTIAL" && stride % 4 == 0;
    if (mode != "ATTRIBUTES" || !(octahedral || quaternion || exponential))
      refuse(ErrorCode::kUnsupportedFeature,
             "The compression filter \"" + filter.substr(0, 40) + "\" is not supported here.",
             pointer + "/filter");
    if (octahedral) meshopt_decodeFilterOct(out.data(), count, stride);
    if (quaternion) meshopt_decodeFilterQuat(out.data(), count, stride);
    if (exponential) meshopt_decodeFilterExp(out.data(), count, stride);
  }
  return out;
}

void decode_draco_primitives(GltfDocument& document, const ImportLimits& limits) {
  if (!document.json.contains("meshes")) return;
  json& meshes = document.json["meshes"];
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    if (!meshes[m].contains("primitives")) continue;
    json& primitives = meshes[m]["primitives"];
    for (std::size_t p = 0; p < primitives.size(); ++p) {
      const auto extensions = primitives[p].find("extensions");
      if (extensions == primitives[p].end() || !extensions->is_object()) continue;
      const auto draco = extensions->find("KHR_draco_mesh_compression");
      if (draco != extensions->end() && draco->is_object())
        decode_primitive(document, primitives[p], limits,
                         "/meshes/" + std::to_string(m) + "/primitives/" + std::to_string(p));
    }
  }
}

}  // namespace fracture
