#include "common/import/gltf_materials.hpp"

#include <algorithm>
#include <cstring>
#include <optional>
#include <set>

#include "common/base/json_reader.hpp"
#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "common/import/gltf_document.hpp"
#include "common/import/refused.hpp"
#include "common/import/uri.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture {
namespace {

using nlohmann::json;

bool begins_with(const std::string& text, const char* prefix) { return text.rfind(prefix, 0) == 0; }

json copy_array(const json& document, const char* key) {
  const auto it = document.find(key);
  return it != document.end() && it->is_array() ? *it : json::array();
}

/// Collects the names of all extensions used at any depth (the keys of "extensions" objects).
void collect_extensions(const json& value, std::set<std::string>& names) {
  if (value.is_object()) {
    for (const auto& [key, child] : value.items()) {
      if (key == "extensions" && child.is_object())
        for (const auto& [name, unused] : child.items()) names.insert(name);
      collect_extensions(child, names);
    }
  } else if (value.is_array()) {
    for (const json& child : value) collect_extensions(child, names);
  }
}

/// Keeps only material extensions. Others could contain indices of objects that the answer does not have.
void drop_foreign_extensions(json& value) {
  if (value.is_object()) {
    if (const auto it = value.find("extensions"); it != value.end() && it->is_object()) {
      std::vector<std::string> foreign;
      for (const auto& [name, unused] : it->items())
        if (!is_material_extension(name)) foreign.push_back(name);
      for (const std::string& name : foreign) it->erase(name);
      if (it->empty()) value.erase("extensions");
    }
    for (auto& [key, child] : value.items())
      if (key != "extras") drop_foreign_extensions(child);
  } else if (value.is_array()) {
    for (json& child : value) drop_foreign_extensions(child);
  }
}

void drop_extras(json& value) {
  if (value.is_object()) {
    value.erase("extras");
    for (auto& [key, child] : value.items()) drop_extras(child);
  } else if (value.is_array()) {
    for (json& child : value) drop_extras(child);
  }
}

/// Limits the memory of the materials. They are kept with the mesh as parsed JSON, which takes up to thirty
/// times its text.
void bound(MaterialLibrary& library, Remarks& remarks, std::vector<Dropped>& dropped) {
  json* const lists[] = {&library.materials, &library.textures, &library.samplers};
  const auto held = [&] { return json_bytes(*lists[0]) + json_bytes(*lists[1]) + json_bytes(*lists[2]); };
  if (held() <= kMaxLibraryBytes) return;
  for (json* list : lists) drop_extras(*list);
  if (const std::size_t bytes = held(); bytes > kMaxLibraryBytes)
    refuse(ErrorCode::kTooLarge,
           "The materials take " + data_size(bytes) + " in memory; the limit is " +
               data_size(kMaxLibraryBytes) +
               ". Remove materials that nothing uses, or merge materials that look the same.",
           "/materials", {{"bytes", bytes}, {"limit", kMaxLibraryBytes}});
  dropped.push_back({"extras", "/materials", "with them the materials would take too much memory"});
  remarks.warn(
      "The materials' extras were left out, because with them the materials would take more than " +
      grouped(kMaxLibraryBytes >> 20) +
      " MiB of memory. So the fragments' materials have no extras. If you need the extras, make them smaller.");
}

using Remap = std::vector<std::uint32_t>;  ///< old index -> new index, or kNoIndex if dropped

/// Rewrites "source" in a texture and its extensions to the new image indices, and drops references to lost
/// images. Returns whether the texture still has an image.
bool remap_sources(json& texture, const Remap& images) {
  bool shows = false;
  const auto rewrite = [&](json& object) {
    const auto it = object.find("source");
    if (it == object.end()) return true;
    const bool known = it->is_number_unsigned() && it->get<std::uint64_t>() < images.size() &&
                       images[it->get<std::uint64_t>()] != kNoIndex;
    if (known) {
      *it = images[it->get<std::uint64_t>()];
      shows = true;
    } else {
      object.erase("source");
    }
    return known;
  };
  rewrite(texture);
  if (const auto extensions = texture.find("extensions");
      extensions != texture.end() && extensions->is_object()) {
    std::vector<std::string> lost;
    for (auto& [name, extension] : extensions->items())
      if (extension.is_object() && !rewrite(extension)) lost.push_back(name);
    for (const std::string& name : lost) extensions->erase(name);
    if (extensions->empty()) texture.erase("extensions");
  }
  return shows;
}

/// Texture references in a material are objects with an "index", under a key that ends in "Texture" (in the
/// core and all ratified extensions). Drops references to lost textures, and renumbers the others.
void remap_textures(json& value, const Remap& textures) {
  if (value.is_array()) {
    for (json& child : value) remap_textures(child, textures);
    return;
  }
  if (!value.is_object()) return;
  std::vector<std::string> lost;
  for (auto& [key, child] : value.items()) {
    if (key == "extras") continue;
    constexpr std::string_view kSuffix = "exture";
    const bool reference = child.is_object() && key.size() >= kSuffix.size() &&
                           key.compare(key.size() - kSuffix.size(), kSuffix.size(), kSuffix) == 0;
    if (reference) {
      const auto index = child.find("index");
      if (index == child.end() || !index->is_number_unsigned() ||
          index->get<std::uint64_t>() >= textures.size() ||
          textures[index->get<std::uint64_t>()] == kNoIndex) {
        lost.push_back(key);
        continue;
      }
      *index = textures[index->get<std::uint64_t>()];
    }
    remap_textures(child, textures);
  }
  for (const std::string& key : lost) value.erase(key);
}

std::optional<Image> read_image(const json& source, const ViewBytes& view_bytes,
                                std::span<const ImportFile> files, const std::string& pointer,
                                Remarks& remarks, std::vector<Dropped>& dropped) {
  Image image;
  if (const auto it = source.find("name"); it != source.end() && it->is_string())
    image.name = it->get<std::string>();
  const auto drop = [&](const std::string& otherwise, const char* reason) {
    dropped.push_back({"image", image.name.empty() ? otherwise : image.name, reason});
    return std::nullopt;
  };
  if (const auto it = source.find("mimeType"); it != source.end() && it->is_string())
    image.mime_type = it->get<std::string>();
  if (source.contains("bufferView")) {
    const auto bytes = view_bytes(unsigned_at(source, "bufferView", kRequired, pointer), pointer);
    image.bytes.assign(bytes.begin(), bytes.end());
  } else if (const auto uri = source.find("uri"); uri != source.end() && uri->is_string()) {
    const auto& text = uri->get_ref<const std::string&>();
    if (is_data_uri(text)) {
      auto data = decode_data_uri(text);
      if (!data)
        refuse(ErrorCode::kMalformedMesh, "The image's data uri is not valid base64.", pointer + "/uri");
      image.bytes = std::move(data->bytes);
      if (image.mime_type.empty()) image.mime_type = data->media_type;
    } else if (const ImportFile* file = find_file(files, text)) {
      const auto* begin = reinterpret_cast<const std::uint8_t*>(file->bytes.data());
      image.bytes.assign(begin, begin + file->bytes.size());
      if (image.name.empty()) image.name = text.substr(text.rfind('/') + 1);
    } else {
      remarks.warn(in_another_file(text));
      return drop(text, "its file was not given");
    }
  } else {
    remarks.warn(
        "The image at " + pointer +
        " has no data and was left out. Surfaces that use it have no texture in the answer. Export the "
        "file again with its images.");
    return drop(pointer, "it has no data");
  }
  // The bytes determine the type; a wrong declaration would be an error in the output file.
  if (const std::string sniffed = sniff_image(image.bytes); !sniffed.empty()) image.mime_type = sniffed;
  if (image.bytes.empty() || image.mime_type.empty()) {
    remarks.warn(
        "The image at " + pointer +
        " is in an unknown format and was left out. Surfaces that use it have no texture in the answer. "
        "Convert the image to PNG or JPEG.");
    return drop(pointer, "its format is unknown");
  }
  return image;
}

}  // namespace

bool is_material_extension(const std::string& name) {
  static const std::set<std::string> kTextures = {"KHR_texture_transform", "KHR_texture_basisu",
                                                  "EXT_texture_webp", "EXT_texture_avif", "MSFT_texture_dds"};
  if (name == "KHR_materials_variants") return false;  // it belongs to primitives, which are created again
  return begins_with(name, "KHR_materials_") || begins_with(name, "EXT_materials_") ||
         kTextures.count(name) > 0;
}

std::string in_another_file(std::string_view image) {
  return "The image \"" + shortened(image) +
         "\" is in another file, which was not given, so it was left out. Surfaces that use it have no texture in the "
         "answer. Embed the image, send it as another part of the form, or, for bake, put it at the path that the mesh names.";
}

std::string sniff_image(std::span<const std::uint8_t> bytes) {
  const auto has = [&](std::size_t at, std::string_view magic) {
    return bytes.size() >= at + magic.size() &&
           std::memcmp(bytes.data() + at, magic.data(), magic.size()) == 0;
  };
  if (has(0, "\x89PNG\r\n\x1a\n")) return "image/png";
  if (has(0, "\xff\xd8\xff")) return "image/jpeg";
  if (has(0, "RIFF") && has(8, "WEBP")) return "image/webp";
  if (has(0, "\xabKTX 20\xbb")) return "image/ktx2";
  return {};
}

MaterialLibrary read_materials(const json& document, const ViewBytes& view_bytes,
                               std::span<const ImportFile> files, Remarks& remarks,
                               std::vector<Dropped>& dropped) {
  MaterialLibrary library;
  library.materials = copy_array(document, "materials");
  library.textures = copy_array(document, "textures");
  library.samplers = copy_array(document, "samplers");
  const json images = copy_array(document, "images");
  for (json* array : {&library.materials, &library.textures, &library.samplers})
    drop_foreign_extensions(*array);

  Remap image_map(images.size(), kNoIndex);
  for (std::size_t k = 0; k < images.size(); ++k)
    if (auto image =
            read_image(images[k], view_bytes, files, "/images/" + std::to_string(k), remarks, dropped)) {
      image_map[k] = static_cast<std::uint32_t>(library.images.size());
      library.images.push_back(std::move(*image));
    }
  Remap texture_map(library.textures.size(), kNoIndex);
  json textures = json::array();
  for (std::size_t k = 0; k < library.textures.size(); ++k) {
    json texture = library.textures[k];
    if (!remap_sources(texture, image_map)) continue;
    if (const auto sampler = texture.find("sampler");
        sampler != texture.end() &&
        (!sampler->is_number_unsigned() || sampler->get<std::uint64_t>() >= library.samplers.size()))
      texture.erase("sampler");
    texture_map[k] = static_cast<std::uint32_t>(textures.size());
    textures.push_back(std::move(texture));
  }
  library.textures = std::move(textures);
  remap_textures(library.materials, texture_map);

  bound(library, remarks, dropped);

  std::set<std::string> used;
  for (const json* array : {&library.materials, &library.textures, &library.samplers})
    collect_extensions(*array, used);
  library.extensions_used.assign(used.begin(), used.end());
  for (const json& name : copy_array(document, "extensionsRequired"))
    if (name.is_string() && used.count(name.get<std::string>()) > 0)
      library.extensions_required.push_back(name.get<std::string>());
  return library;
}

}  // namespace fracture
