#include "common/import/obj_materials.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>

#include "common/base/id.hpp"
#include "common/base/json_reader.hpp"
#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "common/import/file_textures.hpp"
#include "common/import/obj_lines.hpp"
#include "common/import/obj_names.hpp"
#include "common/import/refused.hpp"
#include "common/import/text_encoding.hpp"
#include "common/import/text_words.hpp"
#include "common/import/uri.hpp"

namespace fracture {
namespace {

/// The name with which some exporters mark faces without a material.
constexpr std::string_view kNoMaterialName = "DefaultMaterial";
constexpr float kUnstatedGrey = 0.6f;

std::string in_small_letters(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

bool is_mtl(const ImportFile& file) { return in_small_letters(file.name).ends_with(".mtl"); }

float to_float_in_range(double value) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return static_cast<float>(value > kMost ? kMost : value < -kMost ? -kMost : value);
}

/// Up to three numbers. A colour with fewer repeats its last one, as MTL defines.
std::optional<std::array<float, 3>> color_of(std::string_view rest) {
  std::array<float, 3> color{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string_view word = take_value(rest);
    if (word.empty() && k > 0) {
      color[k] = color[k - 1];
      continue;
    }
    const std::optional<double> value = number_of(word);
    if (!value) return std::nullopt;
    color[k] = to_float_in_range(*value);
  }
  return color;
}

const char* reason_to_leave_out(std::string_view keyword) {
  if (keyword == "bump" || keyword == "map_bump")
    return "it is a height map, but glTF has only normal maps (norm)";
  if (keyword == "map_pr" || keyword == "map_pm") return "glTF needs roughness and metalness in one image";
  if (keyword == "map_d") return "glTF needs opacity and colour in one image";
  return "glTF has no texture of this kind";
}

[[noreturn]] void refuse_materials() {
  refuse(
      ErrorCode::kTooLarge,
      "The materials take more than " + data_size(kMaxLibraryBytes) +
          " of memory, which is the limit. Remove materials that no face uses, or merge those that look the same.",
      {}, {{"limit", kMaxLibraryBytes}});
}

}  // namespace

void ObjMaterials::count(std::size_t bytes) {
  bytes_ += bytes;
  if (bytes_ > kMaxLibraryBytes) refuse_materials();
}

std::uint32_t ObjMaterials::number_of_name(std::string_view name) {
  if (const auto it = numbers_.find(name); it != numbers_.end()) return it->second;
  count(sizeof(Material) + 2 * name.size());
  Material material;
  material.plain.name = name;
  material.plain.color = {kUnstatedGrey, kUnstatedGrey, kUnstatedGrey};
  const auto number = static_cast<std::uint32_t>(materials_.size());
  materials_.push_back(std::move(material));
  numbers_.emplace(name, number);
  return number;
}

std::uint32_t ObjMaterials::use(std::string_view name) {
  return name.empty() || name == kNoMaterialName ? kNoIndex : number_of_name(name);
}

const ImportFile* ObjMaterials::find(const std::string& name) const {
  if (const ImportFile* file = find_file(files_, name)) return file;
  const auto only = std::find_if(files_.begin(), files_.end(), is_mtl);
  return only != files_.end() && std::none_of(only + 1, files_.end(), is_mtl) ? &*only : nullptr;
}

void ObjMaterials::load(std::string_view rest) {
  for (const std::string& name : material_libraries(rest)) {
    if (!asked_.insert(name).second) continue;
    const ImportFile* const file = find(name);
    if (file == nullptr)
      missing_.push_back(name);
    else if (read_.insert(file).second)
      read(*file, name);
  }
}

void ObjMaterials::read(const ImportFile& file, const std::string& name) {
  const std::string folder = name.substr(0, name.find_last_of("/\\") + 1);
  const std::optional<std::string> converted = utf16_to_utf8(file.bytes);
  ObjLines lines(converted
                     ? std::string_view(*converted)
                     : std::string_view(reinterpret_cast<const char*>(file.bytes.data()), file.bytes.size()));
  std::uint32_t current = kNoIndex;
  for (std::string_view line; lines.next(line);) {
    const std::string_view whole = without_blanks(line), word = take_value(line);
    if (word.empty()) continue;
    if (word == "newmtl") {
      current = use(without_blanks(line));
      if (current != kNoIndex) materials_[current].defined = true;
      continue;
    }
    if (current == kNoIndex) continue;
    const std::string keyword = in_small_letters(word);
    if (is_map(keyword)) {
      set_map(materials_[current], keyword, line, folder);
    } else if (!set_value(materials_[current], keyword, line)) {
      if (unreadable_count_++ == 0)
        unreadable_ =
            "line " + std::to_string(lines.number()) + " of " + quotation(name) + ": " + quotation(whole);
    }
  }
}

/// Returns false if the statement's values are not numbers.
bool ObjMaterials::set_value(Material& material, const std::string& keyword, std::string_view rest) {
  PlainMaterial& plain = material.plain;
  if (keyword == "kd" || keyword == "ke") {
    const auto color = color_of(rest);
    if (color) (keyword == "kd" ? plain.color : plain.emission) = *color;
    return color.has_value();
  }
  const bool known =
      keyword == "d" || keyword == "tr" || keyword == "ns" || keyword == "pr" || keyword == "pm";
  if (!known) return true;  // Ka, Ks, illum, …: glTF's materials have nothing that corresponds
  std::string_view word = take_value(rest);
  if (word == "-halo") word = take_value(rest);
  const std::optional<double> number = number_of(word);
  if (!number) return false;
  const float value = to_float_in_range(*number);
  if (keyword == "d") plain.opacity = value;
  if (keyword == "tr") plain.opacity = 1.0f - value;
  if (keyword == "ns") plain.shininess = value;
  if (keyword == "pr") plain.roughness = value;
  if (keyword == "pm") plain.metallic = value;
  return true;
}

void ObjMaterials::set_map(Material& material, const std::string& keyword, std::string_view rest,
                           const std::string& folder) {
  const MapFile map = file_of_map(rest);
  if (map.name.empty()) return;
  count(2 * (sizeof(Map) + folder.size() + map.name.size()));
  std::string file = folder + std::string(map.name);
  PlainMaterial& plain = material.plain;
  std::vector<std::string>* const maps = keyword == "map_kd" ? &plain.color_maps
                                         : keyword == "map_ke" || keyword == "map_emissive"
                                             ? &plain.emission_maps
                                         : keyword == "norm" || keyword == "map_kn" ? &plain.normal_maps
                                                                                    : nullptr;
  if (maps == nullptr) {
    material.left_out.push_back({keyword, std::move(file)});
    return;
  }
  if (map.placed) material.placed.push_back(file);
  *maps = {std::move(file)};
}

void ObjMaterials::warn_about_libraries(const std::vector<bool>& used, Remarks& remarks) const {
  const auto undefined = [&](std::size_t k) { return used[k] && !materials_[k].defined; };
  std::size_t first = 0;
  while (first < materials_.size() && !undefined(first)) ++first;
  const bool lacking = first < materials_.size();
  if (lacking && !missing_.empty()) {
    const std::size_t more = missing_.size() - 1;
    remarks.warn(
        name_as_utf8(printable(shortened(missing_[0]))) +
        (more == 0 ? " was not given"
                   : " and " + counted(more, "more library", "more libraries") + " were not given") +
        ", so materials are missing. Surfaces that use them are grey and have no textures. Send the file as another "
        "part of the form, or, for bake, put it at the path that the mesh names.");
  } else if (lacking && !asked_.empty()) {
    remarks.warn(
        "Faces use the material " + quotation(materials_[first].plain.name) +
        ", but the material libraries do not define it. These faces are grey. Check the name, or export the "
        "libraries again.");
  }
  if (unreadable_count_ > 0)
    remarks.warn(counted(unreadable_count_, "statement of a material library is",
                         "statements of material libraries are") +
                 " not valid MTL and had no effect; the first is " + unreadable_ +
                 ". Colours may be wrong. Correct the file.");
}

MaterialLibrary ObjMaterials::finish(const std::vector<bool>& used, Remarks& remarks,
                                     std::vector<Dropped>& dropped) {
  warn_about_libraries(used, remarks);
  MaterialLibrary library;
  FileTextures textures(files_, library, remarks, dropped);
  const auto find_texture = [&textures](const std::string& name) { return textures.texture(name); };
  std::size_t held = 0;
  for (const Material& material : materials_) {
    nlohmann::json converted = to_gltf(material.plain, find_texture);
    held += json_bytes(converted);
    if (held > kMaxLibraryBytes) refuse_materials();
    library.materials.push_back(std::move(converted));
    const auto& colors = material.plain.color_maps;
    for (const Map& map : material.left_out) {
      // Exporters repeat the picture of the colour as that of the ambient colour.
      if (map.keyword == "map_ka" && std::find(colors.begin(), colors.end(), map.file) != colors.end())
        continue;
      dropped.push_back({"texture", name_as_utf8(map.file), reason_to_leave_out(map.keyword)});
    }
    for (const std::string& file : material.placed)
      dropped.push_back({"texture placement", name_as_utf8(file),
                         "the options -o, -s and -t of a texture are not applied"});
  }
  return library;
}

}  // namespace fracture
