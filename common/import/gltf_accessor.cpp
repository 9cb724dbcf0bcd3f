#include "common/import/gltf_accessor.hpp"

#include <algorithm>
#include <cstring>
#include <string>

#include "common/import/refused.hpp"
#include "common/mesh/gltf_component.hpp"

namespace fracture {
namespace {

const tinygltf::Accessor& accessor_at(const tinygltf::Model& model, int accessor) {
  if (accessor < 0 || static_cast<std::size_t>(accessor) >= model.accessors.size())
    refuse(ErrorCode::kMalformedMesh, "Accessor " + std::to_string(accessor) + " does not exist.");
  return model.accessors[static_cast<std::size_t>(accessor)];
}

template <class T>
T load(const unsigned char* at) {
  T value;
  std::memcpy(&value, at, sizeof(T));
  return value;
}

double component(const unsigned char* at, int type, bool normalized) {
  switch (type) {
    case component_type::kByte:
      return normalized ? std::max(load<std::int8_t>(at) / 127.0, -1.0) : load<std::int8_t>(at);
    case component_type::kUnsignedByte:
      return normalized ? load<std::uint8_t>(at) / 255.0 : load<std::uint8_t>(at);
    case component_type::kShort:
      return normalized ? std::max(load<std::int16_t>(at) / 32767.0, -1.0) : load<std::int16_t>(at);
    case component_type::kUnsignedShort:
      return normalized ? load<std::uint16_t>(at) / 65535.0 : load<std::uint16_t>(at);
    case component_type::kUnsignedInt:
      return normalized ? load<std::uint32_t>(at) / 4294967295.0 : load<std::uint32_t>(at);
    default:
      return load<float>(at);
  }
}

std::uint64_t bytes_of(int type) {
  const std::uint64_t bytes = component_bytes(static_cast<std::uint64_t>(type));
  if (bytes == 0)
    refuse(ErrorCode::kMalformedMesh, std::to_string(type) + " is not a component type of glTF.");
  return bytes;
}

/// Returns the position of `count` elements of `element` bytes. The document was checked before. This is the
/// last defence against a number that the two parsers interpret differently.
const unsigned char* locate(const tinygltf::Model& model, int view, std::uint64_t offset, std::uint64_t count,
                            std::uint64_t element, std::uint64_t stride) {
  if (view < 0 || static_cast<std::size_t>(view) >= model.bufferViews.size())
    refuse(ErrorCode::kMalformedMesh, "bufferView " + std::to_string(view) + " does not exist.");
  const tinygltf::BufferView& v = model.bufferViews[static_cast<std::size_t>(view)];
  if (v.buffer < 0 || static_cast<std::size_t>(v.buffer) >= model.buffers.size())
    refuse(ErrorCode::kMalformedMesh, "Buffer " + std::to_string(v.buffer) + " does not exist.");
  const auto& data = model.buffers[static_cast<std::size_t>(v.buffer)].data;
  const bool view_fits = v.byteOffset <= data.size() && v.byteLength <= data.size() - v.byteOffset;
  const bool fits = view_fits && count > 0 && offset <= v.byteLength && element <= v.byteLength - offset &&
                    count - 1 <= (v.byteLength - offset - element) / stride;
  if (!fits)
    refuse(ErrorCode::kMalformedMesh, "An accessor extends beyond bufferView " + std::to_string(view) + ".");
  return data.data() + v.byteOffset + offset;
}

std::vector<std::uint32_t> read_sparse_indices(const tinygltf::Model& model,
                                               const tinygltf::Accessor& accessor) {
  const auto& indices = accessor.sparse.indices;
  const auto count = static_cast<std::uint64_t>(accessor.sparse.count);
  const std::uint64_t element = bytes_of(indices.componentType);
  const unsigned char* at = locate(model, indices.bufferView, static_cast<std::uint64_t>(indices.byteOffset),
                                   count, element, element);
  std::vector<std::uint32_t> result(count);
  for (std::uint64_t k = 0; k < count; ++k)
    result[k] = static_cast<std::uint32_t>(component(at + k * element, indices.componentType, false));
  return result;
}

}  // namespace

int accessor_width(const tinygltf::Model& model, int accessor) {
  return tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor_at(model, accessor).type));
}

std::vector<double> read_accessor(const tinygltf::Model& model, int index, int width) {
  const tinygltf::Accessor& accessor = accessor_at(model, index);
  if (accessor_width(model, index) != width)
    refuse(ErrorCode::kMalformedMesh,
           "Accessor " + std::to_string(index) + " has elements of " +
               std::to_string(accessor_width(model, index)) + " numbers instead of " + std::to_string(width) +
               ".",
           "/accessors/" + std::to_string(index) + "/type");
  const auto w = static_cast<std::uint64_t>(width);
  const std::uint64_t size = bytes_of(accessor.componentType), element = size * w;
  std::vector<double> values(accessor.count * w, 0.0);
  const auto fill = [&](std::uint64_t to, const unsigned char* from) {
    for (std::uint64_t k = 0; k < w; ++k)
      values[to * w + k] = component(from + k * size, accessor.componentType, accessor.normalized);
  };
  if (accessor.bufferView >= 0) {
    const auto view = static_cast<std::size_t>(accessor.bufferView);
    std::uint64_t stride = view < model.bufferViews.size() ? model.bufferViews[view].byteStride : 0;
    if (stride == 0) stride = element;
    const unsigned char* at =
        locate(model, accessor.bufferView, accessor.byteOffset, accessor.count, element, stride);
    for (std::uint64_t k = 0; k < accessor.count; ++k) fill(k, at + k * stride);
  }
  if (accessor.sparse.isSparse) {
    const std::vector<std::uint32_t> changed = read_sparse_indices(model, accessor);
    const unsigned char* at = locate(model, accessor.sparse.values.bufferView,
                                     static_cast<std::uint64_t>(accessor.sparse.values.byteOffset),
                                     changed.size(), element, element);
    for (std::size_t k = 0; k < changed.size(); ++k) {
      if (changed[k] >= accessor.count)
        refuse(ErrorCode::kMalformedMesh, "A sparse index is outside its accessor.",
               "/accessors/" + std::to_string(index) + "/sparse");
      fill(changed[k], at + k * element);
    }
  }
  return values;
}

std::vector<std::uint32_t> read_indices(const tinygltf::Model& model, int index) {
  const tinygltf::Accessor& accessor = accessor_at(model, index);
  if (!is_index_type(static_cast<std::uint64_t>(accessor.componentType)))
    refuse(ErrorCode::kMalformedMesh, "Indices have to be unsigned integers.",
           "/accessors/" + std::to_string(index));
  const std::vector<double> values = read_accessor(model, index, 1);
  return {values.begin(), values.end()};
}

}  // namespace fracture
