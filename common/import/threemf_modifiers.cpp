#include "common/import/threemf_modifiers.hpp"

#include <charconv>
#include <cstddef>
#include <optional>
#include <string_view>
#include <system_error>

#include "common/import/xml_tags.hpp"

namespace fracture::threemf {
namespace {

std::optional<std::uint32_t> whole(std::string_view tag, std::string_view name) {
  const auto value = xml::attribute(tag, name);
  std::uint32_t number = 0;
  if (!value) return std::nullopt;
  const auto [end, error] = std::from_chars(value->data(), value->data() + value->size(), number);
  if (error != std::errc() || end != value->data() + value->size()) return std::nullopt;
  return number;
}

}  // namespace

/// PrusaSlicer writes the volumes of an object as ranges of triangles of one mesh.
void read_prusa(const std::string& text, Modifiers& modifiers) {
  std::optional<std::uint32_t> object, first, last;
  bool is_modifier = false;
  xml::for_tags(text, [&](std::string_view tag, std::size_t) {
    const std::string_view name = xml::name_of(tag);
    if (name == "object" && !xml::is_end(tag)) object = whole(tag, "id");
    if (name == "volume" && !xml::is_end(tag)) {
      first = whole(tag, "firstid");
      last = whole(tag, "lastid");
      is_modifier = false;
    }
    if (name == "metadata") {
      const auto key = xml::attribute(tag, "key"), value = xml::attribute(tag, "value");
      is_modifier |= key && value && *key == "volume_type" && *value != "ModelPart";
      is_modifier |= key && value && *key == "modifier" && *value == "1";
    }
    if (name == "volume" && xml::is_end(tag) && is_modifier && object && first && last)
      modifiers.triangles[*object].push_back({*first, *last});
    return true;
  });
}

/// Bambu Studio and OrcaSlicer write each volume as a separate object.
void read_bambu(const std::string& text, Modifiers& modifiers) {
  xml::for_tags(text, [&](std::string_view tag, std::size_t) {
    if (xml::name_of(tag) != "part" || xml::is_end(tag)) return true;
    const auto subtype = xml::attribute(tag, "subtype");
    const auto id = whole(tag, "id");
    if (subtype && *subtype != "normal_part" && id) modifiers.objects.insert(*id);
    return true;
  });
}

}  // namespace fracture::threemf
