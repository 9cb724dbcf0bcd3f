#include "common/import/threemf_import.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/id.hpp"
#include "common/base/json_reader.hpp"
#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "common/import/file_positions.hpp"
#include "common/import/gltf_materials.hpp"
#include "common/import/mesh_builder.hpp"
#include "common/import/preflight.hpp"
#include "common/import/refused.hpp"
#include "common/import/text_encoding.hpp"
#include "common/import/threemf_model.hpp"
#include "common/import/threemf_modifiers.hpp"
#include "common/import/xml_tags.hpp"
#include "common/import/zip_archive.hpp"
#include "common/mesh/material_library.hpp"
#include "common/surface_color/mean_pyramid.hpp"

namespace fracture {
namespace {

using nlohmann::json;
using threemf::Instance;
using threemf::ModelPart;
using threemf::Modifiers;
using threemf::Object;

/// Deeper nesting is a loop: real projects have two or three levels.
constexpr int kMaxDepth = 64;
/// Instances of objects, including empty ones.
constexpr std::uint64_t kMaxInstances = 1'000'000;
/// Vertices and triangles of all instances, including those that are left out.
constexpr std::uint64_t kMaxVisited = 200'000'000;

template <class T>
T or_throw(Expected<T> result) {
  if (!result) throw Refused{result.error()};
  return std::move(*result);
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower;
}

/// The files in the archive. Their names are compared without regard to case (OPC, 6.3.5).
class Package {
 public:
  Package(std::span<const std::byte> bytes, const ImportLimits& limits) : bytes_(bytes), limits_(limits) {
    for (const ZipEntry& entry : or_throw(read_zip_directory(bytes, limits.max_decoded_bytes)))
      entries_.emplace(lower_case(threemf::part_path(entry.name)), entry);
  }
  bool has(const std::string& path) const { return entries_.contains(lower_case(path)); }
  std::vector<std::byte> read(const std::string& path) const {
    const auto at = entries_.find(lower_case(path));
    if (at == entries_.end())
      refuse(ErrorCode::kMalformedMesh,
             "The 3MF package does not contain the file \"" + shortened(printable(path)) + "\".");
    return or_throw(unzip(bytes_, at->second, limits_.max_decoded_bytes));
  }
  /// Reads XML, in UTF-8.
  std::string read_text(const std::string& path) const {
    const std::vector<std::byte> bytes = read(path);
    if (auto checked = preflight::check_xml_depth(bytes); !checked) throw Refused{checked.error()};
    if (std::optional<std::string> text = utf16_to_utf8(bytes)) return std::move(*text);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

 private:
  std::span<const std::byte> bytes_;
  const ImportLimits& limits_;
  std::map<std::string, ZipEntry> entries_;
};

/// The path of the model part with the build (OPC relationships of the package).
std::string root_path(const Package& package) {
  std::string path = "3D/3dmodel.model";
  if (!package.has("_rels/.rels")) return path;
  const std::string text = package.read_text("_rels/.rels");
  bool found = false;
  xml::for_tags(text, [&](std::string_view tag, std::size_t) {
    const auto type = xml::attribute(tag, "Type"), target = xml::attribute(tag, "Target");
    if (found || xml::name_of(tag) != "Relationship" || !type || !target || !type->ends_with("/3dmodel"))
      return true;
    path = threemf::part_path(*target);
    found = true;
    return false;
  });
  return path;
}

/// Converts materials, and gives each of them a slot when it is first used.
class Materials {
 public:
  Materials(const Package& package, Remarks& remarks, std::vector<Dropped>& dropped)
      : package_(package), remarks_(remarks), dropped_(dropped) {}

  /// `material`: must live as long as this object.
  std::uint32_t slot(const threemf::Material& material) {
    const auto [known, fresh] = known_.try_emplace(&material, kNoIndex);
    if (fresh) known->second = slot_by_content(material);
    return known->second;
  }
  MaterialLibrary take() { return std::move(library_); }

 private:
  std::uint32_t slot_by_content(const threemf::Material& material) {
    const std::string key = material.name + '\n' + material.color + '\n' + material.texture;
    if (const auto known = slots_.find(key); known != slots_.end()) return known->second;
    json pbr = {{"metallicFactor", 0}};
    json made = json::object();
    if (!material.name.empty()) made["name"] = material.name;
    if (const auto color = linear(material.color)) {
      pbr["baseColorFactor"] = *color;
      if ((*color)[3] < 1) made["alphaMode"] = "BLEND";
    }
    if (!material.texture.empty())
      if (const std::uint32_t texture = texture_of(material.texture); texture != kNoIndex)
        pbr["baseColorTexture"] = {{"index", texture}};
    made["pbrMetallicRoughness"] = std::move(pbr);
    held_ += json_bytes(made);
    if (held_ > kMaxLibraryBytes)
      refuse(ErrorCode::kTooLarge,
             "The materials and colours of the 3MF package take more than " + data_size(kMaxLibraryBytes) +
                 " of memory, which is the limit. Export the file with fewer colours.",
             {}, {{"limit", kMaxLibraryBytes}});
    library_.materials.push_back(std::move(made));
    return slots_[key] = static_cast<std::uint32_t>(library_.materials.size() - 1);
  }

  /// Linear red, green, blue and alpha of "#RRGGBB" or "#RRGGBBAA", to six digits.
  static std::optional<std::array<double, 4>> linear(const std::string& color) {
    if ((color.size() != 7 && color.size() != 9) || color[0] != '#') return std::nullopt;
    std::array<double, 4> result{0, 0, 0, 1};
    for (std::size_t k = 0; 2 * k + 2 < color.size(); ++k) {
      std::uint8_t value = 0;
      const char* const begin = color.data() + 1 + 2 * k;
      const auto [end, error] = std::from_chars(begin, begin + 2, value, 16);
      if (error != std::errc() || end != begin + 2) return std::nullopt;
      const double part = k < 3 ? linear_light(value) / 65535.0 : value / 255.0;
      result[k] = std::round(part * 1e6) / 1e6;
    }
    return result;
  }

  std::uint32_t texture_of(const std::string& path) {
    const auto [known, fresh] = textures_.try_emplace(lower_case(path), kNoIndex);
    if (fresh) known->second = read_texture(path);
    return known->second;
  }

  std::uint32_t read_texture(const std::string& path) {
    Image image;
    if (package_.has(path)) {
      const std::vector<std::byte> bytes = package_.read(path);
      const auto* const begin = reinterpret_cast<const std::uint8_t*>(bytes.data());
      image.bytes.assign(begin, begin + bytes.size());
    }
    image.mime_type = sniff_image(image.bytes);
    if (image.mime_type != "image/png" && image.mime_type != "image/jpeg") {
      const std::string name = name_as_utf8(path);
      remarks_.warn(
          image.bytes.empty()
              ? in_another_file(name)
              : "The image \"" + shortened(name) +
                    "\" is neither PNG nor JPEG and was left out. Surfaces that use it have no texture "
                    "in the answer. Convert the image to PNG or JPEG.");
      dropped_.push_back(
          {"image", name,
           image.bytes.empty() ? "the package does not contain it" : "it is neither PNG nor JPEG"});
      return kNoIndex;
    }
    image.name = name_as_utf8(path.substr(path.find_last_of('/') + 1));
    library_.textures.push_back({{"source", library_.images.size()}});
    library_.images.push_back(std::move(image));
    return static_cast<std::uint32_t>(library_.textures.size() - 1);
  }

  const Package& package_;
  Remarks& remarks_;
  std::vector<Dropped>& dropped_;
  MaterialLibrary library_;
  std::map<std::string, std::uint32_t> slots_;  ///< by content
  std::map<const threemf::Material*, std::uint32_t>
      known_;                                      ///< only searched, because addresses have no order
  std::map<std::string, std::uint32_t> textures_;  ///< by path, in lower case
  std::size_t held_ = 0;                           ///< bytes of the materials
};

class Importer3mf {
 public:
  Importer3mf(std::span<const std::byte> bytes, const ImportLimits& limits)
      : package_(bytes, limits),
        builder_(limits),
        materials_(package_, builder_.remarks(), builder_.dropped()) {}

  Mesh read() {
    const std::string path = root_path(package_);
    if (package_.has(kPrusa)) threemf::read_prusa(package_.read_text(kPrusa), modifiers_);
    for (auto& [id, ranges] : modifiers_.triangles) std::sort(ranges.begin(), ranges.end());
    if (package_.has(kBambu)) threemf::read_bambu(package_.read_text(kBambu), modifiers_);
    const ModelPart& root = part(path);
    if (root.build.empty())
      refuse(ErrorCode::kEmptyMesh,
             "The 3MF package has no build items, so it places no objects. Export it with an object.");
    const auto add_all = [&] {
      instances_ = visited_ = left_out_ = 0;
      for (const Instance& item : root.build) add(item, path, Transform{}, kNoIndex, kNoIndex, 0);
    };
    measuring_ = true;
    add_all();
    measuring_ = false;
    offset_ = offset_for(box_);
    add_all();
    tell();
    builder_.set_library(materials_.take());
    Mesh mesh = or_throw(builder_.finish());
    mesh.frame = {
        .metres = root.metres, .metres_stated = true, .z_up = true, .up_stated = true, .offset = offset_};
    return mesh;
  }

 private:
  static constexpr const char *kPrusa = "Metadata/Slic3r_PE_model.config",
                              *kBambu = "Metadata/model_settings.config";

  const ModelPart& part(const std::string& path) {
    std::unique_ptr<const ModelPart>& known = parts_[lower_case(path)];
    if (!known) {
      known = std::make_unique<const ModelPart>(threemf::read_model_part(package_.read_text(path), path));
      blended_ += known->blended;
      unread_ += known->unread;
    }
    return *known;
  }

  /// Adds the instance to the mesh or, while measuring, to the box. `from`: the part that has it.
  /// `group`, `above`: of the objects that contain it, as a group and as a node of the source.
  void add(const Instance& instance, const std::string& from, const Transform& parent, std::uint32_t group,
           std::uint32_t above, int depth) {
    const std::string path = instance.part.empty() ? from : instance.part;
    const ModelPart& of = part(path);
    const auto found = of.objects.find(instance.object);
    if (found == of.objects.end())
      refuse(ErrorCode::kMalformedMesh, "The 3MF package refers to object " +
                                            std::to_string(instance.object) + " of \"" +
                                            shortened(printable(path)) + "\", which does not exist.");
    if (depth > kMaxDepth)
      refuse(ErrorCode::kMalformedMesh, "Object " + std::to_string(instance.object) + " of \"" +
                                            shortened(printable(path)) + "\" contains itself.");
    if (++instances_ > kMaxInstances)
      refuse(ErrorCode::kTooLarge,
             "The 3MF package has more than " + grouped(kMaxInstances) +
                 " instances of objects, which is the limit. Divide it into several files.");
    const Object& object = found->second;
    if (object.type == "support" || object.type == "solidsupport" ||
        modifiers_.objects.contains(instance.object)) {
      ++left_out_;
      return;
    }
    const Transform world = parent == Transform{}               ? instance.transform
                            : instance.transform == Transform{} ? parent
                                                                : parent * instance.transform;
    const std::uint32_t own =
        measuring_ ? above
                   : builder_.add_source_node(
                         object.name.empty() && !object.triangles.empty() ? "mesh" : object.name, above);
    if (!object.triangles.empty()) add_mesh(of, object, instance.object, world, group, own);
    const std::uint32_t below =
        object.components.empty() || measuring_ ? group : builder_.add_group(object.name, group);
    for (const Instance& component : object.components) add(component, path, world, below, own, depth + 1);
  }

  void add_mesh(const ModelPart& of, const Object& object, std::uint32_t id, const Transform& world,
                std::uint32_t group, std::uint32_t source_node) {
    static const std::vector<std::array<std::uint32_t, 2>> kNoRanges;
    const auto modifier = modifiers_.triangles.find(id);
    const std::vector<std::array<std::uint32_t, 2>>& ranges =
        modifier == modifiers_.triangles.end() ? kNoRanges : std::as_const(modifier->second);
    visited_ += object.vertices.size() + object.triangles.size() + ranges.size();
    if (visited_ > kMaxVisited)
      refuse(ErrorCode::kTooLarge,
             "The instances in the 3MF package have more than " + grouped(kMaxVisited) +
                 " vertices and triangles, which is the limit. Reduce the number of copies.");
    Surface surface;
    const bool identity = world == Transform{}, mirrored = world.determinant() < 0;
    const bool has_uvs = !object.uvs.empty();
    const auto place = [&](std::uint32_t v) {
      const Vec3d& p = object.vertices[v];
      return (identity ? p : world.point(p)) - offset_;
    };
    if (measuring_) {
      for (const auto& triangle : object.triangles)
        for (const std::uint32_t v : triangle)
          if (const Vec3d p = place(v); FilePositions::fits(p)) box_.add(p);
      return;
    }
    if (!has_uvs)
      for (std::uint32_t v = 0; v < object.vertices.size(); ++v)
        surface.positions.push_back(to_float(place(v)));
    else
      surface.attributes.uvs.emplace_back();
    std::size_t next = 0, left_out_until = 0;
    for (std::size_t t = 0; t < object.triangles.size(); ++t) {
      for (; next < ranges.size() && ranges[next][0] <= t; ++next)
        left_out_until = std::max(left_out_until, std::size_t{ranges[next][1]} + 1);
      if (t < left_out_until) continue;
      std::array<std::uint32_t, 3> corners = object.triangles[t];
      for (std::size_t k = 0; has_uvs && k < 3; ++k) {
        surface.positions.push_back(to_float(place(corners[k])));
        surface.attributes.uvs[0].push_back(t < object.uvs.size() ? object.uvs[t][k] : Vec2f{});
        corners[k] = static_cast<std::uint32_t>(surface.positions.size() - 1);
      }
      if (mirrored) std::swap(corners[1], corners[2]);
      surface.triangles.push_back(corners);
      const std::uint32_t material = object.materials[t];
      surface.materials.push_back(material == kNoIndex ? kNoIndex : materials_.slot(of.materials[material]));
    }
    left_out_ += ranges.size();
    if (surface.triangles.empty()) return;
    if (has_uvs) merge_identical_wedges(surface);
    builder_.begin_node(object.name.empty() ? "mesh" : object.name, group);
    builder_.set_source_node(source_node);
    if (auto added = builder_.add(std::move(surface)); !added) throw Refused{added.error()};
  }

  void tell() {
    Remarks& remarks = builder_.remarks();
    if (left_out_ > 0)
      remarks.note(counted(left_out_, "object or volume was", "objects or volumes were") +
                   " left out, because slicers do not print supports, modifiers or negative volumes.");
    if (blended_ > 0)
      remarks.note(counted(blended_, "triangle blends", "triangles blend") +
                   " several colours. The colour of the first corner was used for the whole triangle.");
    if (unread_ > 0)
      remarks.warn(
          counted(unread_, "triangle has", "triangles have") +
          " properties of an unsupported kind (such as multiproperties or composite materials) and therefore "
          "no material in the answer. Export the file with base materials, colours or textures.");
  }

  Package package_;
  MeshBuilder builder_;
  Materials materials_;
  Modifiers modifiers_;
  std::map<std::string, std::unique_ptr<const ModelPart>> parts_;
  bool measuring_ = false;
  Box box_;       ///< of all surfaces
  Vec3d offset_;  ///< subtracted from all positions (file_positions.hpp)
  std::uint64_t instances_ = 0, visited_ = 0, left_out_ = 0, blended_ = 0, unread_ = 0;
};

}  // namespace

Expected<Mesh> import_3mf(std::span<const std::byte> bytes, const ImportLimits& limits) {
  try {
    return Importer3mf(bytes, limits).read();
  } catch (const Refused& refused) {
    return tl::unexpected<Error>(refused.error);
  }
}

}  // namespace fracture
