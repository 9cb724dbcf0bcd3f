#include "common/gltf/gltf_writer.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>

#include "common/gltf/fracture_extras.hpp"
#include "common/gltf/json_text.hpp"
#include "common/gltf/names.hpp"
#include "common/gltf/vertex_data.hpp"
#include "common/solid/solid.hpp"

namespace fracture {
namespace {

constexpr int kFloat = 5126, kUnsignedShort = 5123, kUnsignedInt = 5125;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
/// 65,535 would be the restart index of a 16-bit strip and is not allowed as an index.
constexpr std::size_t kMaxShortVertices = 65535;

/// Does the material (or one of its extensions) have a normal map? Only those need tangents.
bool has_normal_texture(const nlohmann::json& value) {
  if (!value.is_object()) return false;
  for (const auto& [key, child] : value.items()) {
    if (key == "extras") continue;
    if (key == "normalTexture" || key == "clearcoatNormalTexture" || has_normal_texture(child)) return true;
  }
  return false;
}

void check(const Fragment& f) {
  const std::size_t count = f.positions.size();
  const auto sized = [count](const auto& values) { return values.empty() || values.size() == count; };
  bool good = count > 0 && !f.indices.empty() && sized(f.attributes.normals) && sized(f.attributes.tangents);
  for (const auto& set : f.attributes.uvs) good = good && set.size() == count;
  for (const auto& set : f.attributes.colors) good = good && set.size() == count;
  for (const std::uint32_t index : f.indices) good = good && index < count;
  std::size_t covered = 0;
  for (const FragmentPrimitive& p : f.primitives) {
    good = good && p.first_index == covered && p.index_count > 0 && p.index_count % 3 == 0;
    covered += p.index_count;
  }
  if (!good || covered != f.indices.size())
    throw InternalError("fragment " + std::to_string(f.id) + " contradicts its own description: " +
                        std::to_string(count) + " vertices, " + std::to_string(f.indices.size()) +
                        " indices, primitives cover " + std::to_string(covered));
}

/// The bufferViews in the order they first get a byte, and the accessors into them, whose JSON grows
/// alongside.
class Accessors {
 public:
  struct View {
    ViewBytes bytes;
    int stride;  ///< 0 for indices and images
    int target;  ///< 0 for images
  };

  Accessors() { json_.begin_array(); }

  std::size_t view(std::string_view name, int stride, int target) {
    for (std::size_t k = 0; k < names_.size(); ++k)
      if (names_[k] == name) return k;
    names_.emplace_back(name);
    views_.push_back({{}, stride, target});
    return views_.size() - 1;
  }
  ViewBytes& bytes(std::size_t view) { return views_[view].bytes; }
  const std::vector<View>& views() const { return views_; }

  /// Begins an accessor over what is appended to the view from byte `offset` on; returns its index.
  std::size_t add(std::size_t view, std::size_t offset, int component, std::size_t count, const char* type,
                  const Vec3f* min = nullptr, const Vec3f* max = nullptr) {
    json_.begin_object().member("bufferView", view);
    if (offset > 0) json_.member("byteOffset", offset);
    json_.member("componentType", component).member("count", count).member("type", type);
    if (min != nullptr) json_.member("min", to_double(*min)).member("max", to_double(*max));
    json_.end_object();
    return count_++;
  }
  std::string finish() {
    json_.end_array();
    return json_.take();
  }
  std::size_t count() const { return count_; }

 private:
  std::vector<std::string> names_;
  std::vector<View> views_;
  JsonText json_;
  std::size_t count_ = 0;
};

/// Appends one mesh: attribute accessors shared by its primitives, indices in one view.
class MeshWriter {
 public:
  MeshWriter(const MaterialLibrary& library, Accessors& accessors) : accessors_(accessors) {
    interior_ = library.materials.size();
    for (const auto& material : library.materials) normal_mapped_.push_back(has_normal_texture(material));
  }

  void write(JsonText& json, const Fragment& f, const std::string& name) {
    const bool tangents =
        !f.attributes.tangents.empty() && std::any_of(f.primitives.begin(), f.primitives.end(),
                                                      [&](const auto& p) { return needs_tangents(p); });
    std::vector<std::pair<std::string, std::size_t>> attributes;
    const std::size_t count = f.positions.size();
    Vec3f min, max;
    const std::size_t position_view = accessors_.view("POSITION", sizeof(Vec3f), kArrayBuffer);
    const std::size_t position_at = accessors_.bytes(position_view).size();
    append_positions(accessors_.bytes(position_view), f.positions, min, max);
    attributes.emplace_back("POSITION",
                            accessors_.add(position_view, position_at, kFloat, count, "VEC3", &min, &max));
    const auto attribute = [&](const std::string& semantic, int stride, const char* type, auto&& append) {
      const std::size_t view = accessors_.view(semantic, stride, kArrayBuffer);
      const std::size_t at = accessors_.bytes(view).size();
      append(accessors_.bytes(view));
      attributes.emplace_back(semantic, accessors_.add(view, at, kFloat, count, type));
    };
    if (!f.attributes.normals.empty())
      attribute("NORMAL", sizeof(Vec3f), "VEC3", [&](ViewBytes& view) { append_normals(view, f); });
    for (std::size_t set = 0; set < f.attributes.uvs.size(); ++set)
      attribute("TEXCOORD_" + std::to_string(set), sizeof(Vec2f), "VEC2",
                [&](ViewBytes& view) { append_uvs(view, f.attributes.uvs[set]); });
    for (std::size_t set = 0; set < f.attributes.colors.size(); ++set)
      attribute("COLOR_" + std::to_string(set), sizeof(Vec4f), "VEC4",
                [&](ViewBytes& view) { append_colors(view, f.attributes.colors[set]); });
    if (tangents)
      attribute("TANGENT", sizeof(Vec4f), "VEC4", [&](ViewBytes& view) { append_tangents(view, f); });

    const bool wide = count > kMaxShortVertices;
    const std::size_t index_view = accessors_.view(wide ? "indices32" : "indices16", 0, kElementArrayBuffer);
    const std::size_t indices_at = append_indices(accessors_.bytes(index_view), f.indices, wide);

    json.begin_object().member("name", name).key("primitives").begin_array();
    for (const FragmentPrimitive& p : f.primitives) {
      const std::size_t bytes = wide ? 4 : 2;
      json.begin_object().key("attributes").begin_object();
      for (const auto& [semantic, accessor] : attributes)
        if (semantic != "TANGENT" || needs_tangents(p)) json.member(semantic, accessor);
      json.end_object();
      json.member("indices", accessors_.add(index_view, indices_at + bytes * p.first_index,
                                            wide ? kUnsignedInt : kUnsignedShort, p.index_count, "SCALAR"));
      if (p.material == kInteriorMaterial)
        json.member("material", interior_);
      else if (p.material < interior_)
        json.member("material", p.material);
      json.end_object();
    }
    json.end_array().end_object();
  }

 private:
  bool needs_tangents(const FragmentPrimitive& p) const {
    return p.material < normal_mapped_.size() && normal_mapped_[p.material];
  }

  static std::size_t append_indices(ViewBytes& view, const std::vector<std::uint32_t>& indices, bool wide) {
    view.align(4);
    const std::size_t at = view.size();
    if (wide) {
      std::memcpy(view.extend(indices.size() * 4), indices.data(), indices.size() * 4);
      return at;
    }
    std::uint8_t* out = view.extend(indices.size() * 2);
    for (const std::uint32_t index : indices) {
      const auto narrow = static_cast<std::uint16_t>(index);
      std::memcpy(out, &narrow, 2);
      out += 2;
    }
    return at;
  }

  Accessors& accessors_;
  std::size_t interior_ = 0;
  std::vector<bool> normal_mapped_;
};

void write_string_array(JsonText& json, std::string_view key, const std::vector<std::string>& values) {
  if (values.empty()) return;
  json.key(key).begin_array();
  for (const std::string& value : values) json.value(value);
  json.end_array();
}

void write_asset(JsonText& json, const FragmentSet& set, const GltfOptions& options) {
  json.key("asset").begin_object().member("version", "2.0");
  json.member("generator", "fracture, algorithm " + std::to_string(options.algorithm));
  if (!set.source->copyright.empty()) json.member("copyright", set.source->copyright);
  json.key("extras").begin_object().member("parameters", options.parameters);
  if (!options.mesh_digest.empty()) json.member("mesh", options.mesh_digest);
  json.end_object().end_object();
}

void write_nodes(JsonText& json, const FragmentSet& set, const GltfOptions& options,
                 const std::vector<std::string>& names) {
  json.member("scene", 0).key("scenes").begin_array().begin_object();
  json.key("nodes").begin_array().value(0).end_array().end_object().end_array();
  json.key("nodes").begin_array().begin_object().member("name", "Fracture");
  if (!set.fragments.empty()) {
    json.key("children").begin_array();
    for (std::size_t k = 0; k < set.fragments.size(); ++k) json.value(k + 1);
    json.end_array();
  }
  json.key("extras").begin_object().key("fracture");
  write_root_extras(json, set, options);
  json.end_object().end_object();
  for (std::size_t k = 0; k < set.fragments.size(); ++k) {
    const Fragment& f = set.fragments[k];
    json.begin_object().member("name", names[k]).member("mesh", k);
    if (!(f.pivot == Vec3d{})) json.member("translation", f.pivot);
    json.key("extras").begin_object().key("fracture");
    write_fragment_extras(json, f, options);
    json.end_object().end_object();
  }
  json.end_array();
}

/// The source's materials, textures and samplers in source order, then the interior material.
void write_materials(JsonText& json, const MaterialLibrary& library, const GltfOptions& options) {
  json.key("materials").begin_array();
  for (const auto& material : library.materials) json.value(material);
  json.value(options.interior_material).end_array();
  if (!library.textures.empty()) json.member("textures", library.textures);
  if (!library.samplers.empty()) json.member("samplers", library.samplers);
}

void write_images(JsonText& json, const MaterialLibrary& library, Accessors& accessors) {
  if (library.images.empty()) return;
  json.key("images").begin_array();
  for (std::size_t k = 0; k < library.images.size(); ++k) {
    const Image& image = library.images[k];
    const std::size_t view = accessors.view("image " + std::to_string(k), 0, 0);
    std::memcpy(accessors.bytes(view).extend(image.bytes.size()), image.bytes.data(), image.bytes.size());
    json.begin_object();
    if (!image.name.empty()) json.member("name", image.name);
    json.member("mimeType", image.mime_type).member("bufferView", view).end_object();
  }
  json.end_array();
}

std::size_t aligned(std::size_t size) { return (size + 3) / 4 * 4; }

/// Writes bufferViews and the buffer; returns the length of the BIN chunk.
std::size_t write_views(JsonText& json, const std::vector<Accessors::View>& views) {
  std::size_t offset = 0;
  if (views.empty()) return 0;
  json.key("bufferViews").begin_array();
  for (const Accessors::View& view : views) {
    json.begin_object().member("buffer", 0);
    if (offset > 0) json.member("byteOffset", offset);
    json.member("byteLength", view.bytes.size());
    if (view.stride > 0) json.member("byteStride", view.stride);
    if (view.target > 0) json.member("target", view.target);
    json.end_object();
    offset += aligned(view.bytes.size());
  }
  json.end_array();
  json.key("buffers").begin_array().begin_object().member("byteLength", offset).end_object().end_array();
  return offset;
}

void put_u32(std::uint8_t*& out, std::size_t value) {
  const auto narrow = static_cast<std::uint32_t>(value);
  std::memcpy(out, &narrow, 4);
  out += 4;
}

std::vector<std::uint8_t> pack(const std::string& json, const std::vector<Accessors::View>& views,
                               std::size_t binary) {
  const std::size_t json_size = aligned(json.size());
  const std::size_t total = 12 + 8 + json_size + (binary > 0 ? 8 + binary : 0);
  if (total > std::numeric_limits<std::uint32_t>::max())
    throw InternalError("the GLB would be larger than 4 GiB");
  std::vector<std::uint8_t> glb(total);
  std::uint8_t* out = glb.data();
  put_u32(out, 0x46546c67);  // "glTF"
  put_u32(out, 2);
  put_u32(out, total);
  put_u32(out, json_size);
  put_u32(out, 0x4e4f534a);  // "JSON"
  std::memcpy(out, json.data(), json.size());
  std::memset(out + json.size(), ' ', json_size - json.size());
  out += json_size;
  if (binary == 0) return glb;
  put_u32(out, binary);
  put_u32(out, 0x004e4942);  // "BIN"
  for (const Accessors::View& view : views) {
    if (view.bytes.size() > 0) std::memcpy(out, view.bytes.data(), view.bytes.size());
    out += aligned(view.bytes.size());
  }
  return glb;
}

}  // namespace

std::vector<std::uint8_t> write_glb(const FragmentSet& set, const GltfOptions& options) {
  const MaterialLibrary& library = *set.source->library;
  std::vector<std::string> names;
  names.reserve(set.fragments.size());
  for (const Fragment& f : set.fragments) {
    check(f);
    const auto& sources = set.source->node_names;
    names.push_back(fragment_name(f.node < sources.size() ? sources[f.node] : "mesh", names.size(),
                                  set.fragments.size()));
  }

  JsonText json;
  json.reserve(4096 + 1200 * set.fragments.size() + 200 * set.bonds.size());
  json.begin_object();
  write_asset(json, set, options);
  write_string_array(json, "extensionsUsed", library.extensions_used);
  write_string_array(json, "extensionsRequired", library.extensions_required);
  write_nodes(json, set, options, names);
  write_materials(json, library, options);
  Accessors accessors;
  if (!set.fragments.empty()) {
    MeshWriter writer(library, accessors);
    json.key("meshes").begin_array();
    for (std::size_t k = 0; k < set.fragments.size(); ++k) writer.write(json, set.fragments[k], names[k]);
    json.end_array();
  }
  write_images(json, library, accessors);
  if (accessors.count() > 0) json.key("accessors").value_text(accessors.finish());
  const std::size_t binary = write_views(json, accessors.views());
  json.end_object();
  return pack(json.text(), accessors.views(), binary);
}

}  // namespace fracture
