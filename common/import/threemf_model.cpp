#include "common/import/threemf_model.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "common/base/printable.hpp"
#include "common/import/refused.hpp"
#include "common/import/text_encoding.hpp"
#include "common/import/xml_tags.hpp"

namespace fracture::threemf {
namespace {

/// Extensions that may be required, because their shapes are read: materials, production, sets of triangles.
constexpr std::array<std::string_view, 4> kSupported{
    "http://schemas.microsoft.com/3dmanufacturing/core/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/production/2015/06",
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07"};

/// Metres per unit (3MF Core, ST_Unit).
constexpr std::array<std::pair<std::string_view, double>, 6> kUnits{{{"micron", 1e-6},
                                                                     {"millimeter", 1e-3},
                                                                     {"centimeter", 1e-2},
                                                                     {"inch", 0.0254},
                                                                     {"foot", 0.3048},
                                                                     {"meter", 1}}};

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) + 1 - begin);
}

/// Replaces the entities that XML defines. Others stay as they are.
std::string decoded(std::string_view raw) {
  constexpr std::array<std::pair<std::string_view, char>, 5> kEntities{
      {{"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}, {"&amp;", '&'}}};
  std::string text;
  for (std::size_t k = 0; k < raw.size(); ++k) {
    const auto entity = std::find_if(kEntities.begin(), kEntities.end(), [&](const auto& each) {
      return raw.substr(k, each.first.size()) == each.first;
    });
    text += entity == kEntities.end() ? raw[k] : entity->second;
    if (entity != kEntities.end()) k += entity->first.size() - 1;
  }
  return name_as_utf8(text);
}

/// Shortens a name, because each instance of an object has a copy of it. Characters of UTF-8 stay whole.
std::string cut(std::string name) {
  constexpr std::size_t kLongest = 1000;
  if (name.size() <= kLongest) return name;
  std::size_t end = kLongest;
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;
  name.resize(end);
  return name;
}

class Reader {
 public:
  Reader(std::string_view text, const std::string& path) : text_(text), path_(path) {}

  ModelPart read() {
    bool is_model = false;
    xml::for_tags(text_, [&](std::string_view tag, std::size_t at) {
      at_ = at;
      const std::string_view name = xml::name_of(tag);
      is_model |= name == "model";
      xml::is_end(tag) ? leave(name) : enter(tag, name);
      return true;
    });
    if (!is_model) wrong("it has no <model> element");
    return std::move(part_);
  }

 private:
  [[noreturn]] void wrong(const std::string& what) const {
    refuse(ErrorCode::kMalformedMesh, "The 3MF part \"" + shortened(printable(path_)) +
                                          "\" has an error at byte " + std::to_string(at_) + ": " + what +
                                          ".");
  }

  void enter(std::string_view tag, std::string_view name) {
    if (name == "vertex") return add_vertex(tag);
    if (name == "triangle") return add_triangle(tag);
    if (name == "model") return enter_model(tag);
    if (name == "object") {
      object_ = &part_.objects[id_of(tag)];
      *object_ = {};
      object_->name = cut(text_of(tag, "name"));
      object_->type = text_of(tag, "type");
      group_of_object_ = whole(tag, "pid");
      index_of_object_ = whole(tag, "pindex").value_or(0);
      if (xml::is_empty_element(tag)) object_ = nullptr;
    } else if (name == "component" && object_) {
      object_->components.push_back(instance(tag));
    } else if (name == "item") {
      part_.build.push_back(instance(tag));
    } else if (name == "texture2d") {
      textures_[id_of(tag)] = part_path(text_of(tag, "path"));
    } else if (name == "basematerials" || name == "colorgroup" || name == "texture2dgroup") {
      begin_group(tag, name);
    } else if (group_ && (name == "base" || name == "color" || name == "tex2coord")) {
      add_property(tag, name);
    }
  }

  void leave(std::string_view name) {
    if (name == "object") object_ = nullptr;
    if (name == "basematerials" || name == "colorgroup" || name == "texture2dgroup") group_ = nullptr;
  }

  void enter_model(std::string_view tag) {
    if (const std::string unit = text_of(tag, "unit"); !unit.empty()) {
      const auto found =
          std::find_if(kUnits.begin(), kUnits.end(), [&](const auto& each) { return each.first == unit; });
      if (found == kUnits.end()) wrong("the unit '" + shortened(printable(unit)) + "' does not exist");
      part_.metres = found->second;
    }
    std::map<std::string_view, std::string_view> namespaces;  // by their prefixes
    xml::for_attributes(tag, [&](std::string_view name, std::string_view value) {
      constexpr std::string_view kDeclaration = "xmlns:";
      if (name.starts_with(kDeclaration)) namespaces[name.substr(kDeclaration.size())] = value;
    });
    const std::string required = text_of(tag, "requiredextensions");
    for (std::string_view rest = required; !(rest = trimmed(rest)).empty();) {
      const std::string_view prefix = rest.substr(0, rest.find_first_of(" \t\r\n"));
      rest.remove_prefix(prefix.size());
      const auto known = namespaces.find(prefix);
      const std::string meant = known != namespaces.end() ? decoded(known->second) : std::string(prefix);
      if (std::find(kSupported.begin(), kSupported.end(), meant) == kSupported.end())
        refuse(ErrorCode::kUnsupportedFeature,
               "The 3MF part \"" + shortened(printable(path_)) + "\" requires the extension " +
                   shortened(printable(meant)) +
                   ", which is not supported. Export the file without it, or as GLB or STL.");
    }
  }

  void begin_group(std::string_view tag, std::string_view name) {
    group_ = &groups_[id_of(tag)];
    *group_ = {};
    texture_material_ = kNoIndex;
    if (name != "texture2dgroup") return;
    const std::optional<std::uint32_t> id = whole(tag, "texid");
    const auto texture = id ? textures_.find(*id) : textures_.end();
    if (texture == textures_.end()) wrong("the texture of a group does not exist");
    texture_material_ = add_material({{}, {}, texture->second});
  }

  std::uint32_t add_material(Material material) {
    part_.materials.push_back(std::move(material));
    return static_cast<std::uint32_t>(part_.materials.size() - 1);
  }

  void add_property(std::string_view tag, std::string_view name) {
    if (name == "tex2coord") {
      group_->materials.push_back(texture_material_);
      group_->uvs.push_back({static_cast<float>(number(tag, "u")), static_cast<float>(1 - number(tag, "v"))});
    } else if (name == "base") {
      group_->materials.push_back(add_material({text_of(tag, "name"), text_of(tag, "displaycolor"), {}}));
    } else {
      group_->materials.push_back(add_material({{}, text_of(tag, "color"), {}}));
    }
  }

  void add_vertex(std::string_view tag) {
    if (!object_) wrong("a vertex is outside an object");
    object_->vertices.push_back({number(tag, "x"), number(tag, "y"), number(tag, "z")});
  }

  void add_triangle(std::string_view tag) {
    if (!object_) wrong("a triangle is outside an object");
    std::array<std::uint32_t, 3> corners{};
    constexpr std::array<std::string_view, 3> kCorners{"v1", "v2", "v3"}, kProperties{"p1", "p2", "p3"};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::optional<std::uint32_t> vertex = whole(tag, kCorners[k]);
      if (!vertex) wrong("a triangle has no vertex " + std::string(kCorners[k]));
      if (*vertex >= object_->vertices.size())
        wrong("a triangle refers to vertex " + std::to_string(*vertex) + "; the object has " +
              std::to_string(object_->vertices.size()) + " vertices");
      corners[k] = *vertex;
    }
    object_->triangles.push_back(corners);
    const std::optional<std::uint32_t> own = whole(tag, "pid"), first = whole(tag, kProperties[0]);
    std::array<std::uint32_t, 3> properties;
    properties.fill(first.value_or(index_of_object_));
    for (std::size_t k = 1; first && k < 3; ++k) properties[k] = whole(tag, kProperties[k]).value_or(*first);
    add_look(first ? (own ? own : group_of_object_) : group_of_object_, properties);
  }

  /// Adds the material and the UVs of the last triangle.
  void add_look(const std::optional<std::uint32_t>& id, const std::array<std::uint32_t, 3>& properties) {
    std::uint32_t material = kNoIndex;
    std::array<Vec2f, 3> uvs{};
    bool has_texture = false;
    if (id) {
      const auto group = groups_.find(*id);
      if (group == groups_.end()) {
        ++part_.unread;
      } else {
        const PropertyGroup& of = group->second;
        for (const std::uint32_t property : properties)
          if (property >= of.materials.size())
            wrong("a triangle refers to property " + std::to_string(property) + "; its group has " +
                  std::to_string(of.materials.size()));
        material = of.materials[properties[0]];
        has_texture = !of.uvs.empty();
        for (std::size_t k = 0; has_texture && k < 3; ++k) uvs[k] = of.uvs[properties[k]];
        part_.blended += !has_texture && (properties[1] != properties[0] || properties[2] != properties[0]);
      }
    }
    object_->materials.push_back(material);
    if (has_texture) object_->uvs.resize(object_->triangles.size() - 1);
    if (has_texture || !object_->uvs.empty()) object_->uvs.push_back(uvs);
  }

  Instance instance(std::string_view tag) const {
    const std::optional<std::uint32_t> object = whole(tag, "objectid");
    if (!object) wrong("an item or component has no objectid");
    Instance made{part_path(text_of(tag, "path")), *object, {}};
    const std::string given = text_of(tag, "transform");
    if (trimmed(given).empty()) return made;
    // Row vectors are multiplied from the left, so the rows of the file are the columns of a Transform.
    std::array<double, 12> m{};
    std::string_view rest = given;
    for (double& value : m) {
      rest = trimmed(rest);
      const std::string_view word = rest.substr(0, rest.find_first_of(" \t\r\n"));
      rest.remove_prefix(word.size());
      value = parsed(word, "transform");
    }
    made.transform = {{m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}, {m[9], m[10], m[11]}};
    return made;
  }

  static std::string text_of(std::string_view tag, std::string_view name) {
    const std::optional<std::string_view> value = xml::attribute(tag, name);
    return value ? decoded(*value) : std::string();
  }

  std::uint32_t id_of(std::string_view tag) const {
    const std::optional<std::uint32_t> id = whole(tag, "id");
    if (!id) wrong("a resource has no id");
    return *id;
  }

  std::optional<std::uint32_t> whole(std::string_view tag, std::string_view name) const {
    const std::optional<std::string_view> value = xml::attribute(tag, name);
    if (!value) return std::nullopt;
    const std::string_view word = trimmed(*value);
    std::uint32_t number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc() || end != word.data() + word.size())
      wrong("'" + std::string(name) + "' must be a whole number; it is '" + shortened(printable(word)) + "'");
    return number;
  }

  double number(std::string_view tag, std::string_view name) const {
    const std::optional<std::string_view> value = xml::attribute(tag, name);
    if (!value) wrong("'" + std::string(name) + "' is missing");
    return parsed(trimmed(*value), name);
  }

  double parsed(std::string_view word, std::string_view name) const {
    if (word.starts_with('+')) word.remove_prefix(1);
    double number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (word.empty() || error != std::errc() || end != word.data() + word.size() || !std::isfinite(number))
      wrong("'" + std::string(name) + "' must be a number; it is '" + shortened(printable(word)) + "'");
    return number;
  }

  std::string_view text_;
  const std::string& path_;
  std::size_t at_ = 0;  ///< of the current tag
  ModelPart part_;
  std::map<std::uint32_t, std::string> textures_;
  std::map<std::uint32_t, PropertyGroup> groups_;
  Object* object_ = nullptr;        ///< the object around the current tag
  PropertyGroup* group_ = nullptr;  ///< likewise
  std::uint32_t texture_material_ = kNoIndex;
  std::optional<std::uint32_t> group_of_object_;
  std::uint32_t index_of_object_ = 0;
};

}  // namespace

std::string part_path(std::string_view target) {
  while (target.starts_with('/')) target.remove_prefix(1);
  return std::string(target);
}

ModelPart read_model_part(std::string_view text, const std::string& path) {
  return Reader(text, path).read();
}

}  // namespace fracture::threemf
