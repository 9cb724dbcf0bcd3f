#include "common/import/gltf_variants.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "common/base/json_reader.hpp"
#include "common/mesh/copied_limits.hpp"

namespace fracture {
namespace {

using nlohmann::json;

constexpr const char* kName = "KHR_materials_variants";

/// Returns the member, or null if there is none of this type.
const json* member(const json& object, const char* key, json::value_t type) {
  if (!object.is_object()) return nullptr;
  const auto it = object.find(key);
  return it != object.end() && it->type() == type ? &*it : nullptr;
}

/// Returns the list `key` of the object's KHR_materials_variants, or null.
const json* list_of(const json& object, const char* key) {
  const json* const extensions = member(object, "extensions", json::value_t::object);
  const json* const extension =
      extensions != nullptr ? member(*extensions, kName, json::value_t::object) : nullptr;
  return extension != nullptr ? member(*extension, key, json::value_t::array) : nullptr;
}

std::optional<std::size_t> index_in(const json& object, const char* key, std::size_t count) {
  const json* const index = member(object, key, json::value_t::number_unsigned);
  if (index == nullptr || index->get<std::uint64_t>() >= count) return std::nullopt;
  return index->get<std::size_t>();
}

/// Removes nested extensions. They could contain indices of objects that the answer does not have.
json without_extensions(json object) {
  if (object.is_object()) object.erase("extensions");
  return object;
}

bool is_sound(const json& mapping, std::size_t materials, std::size_t variants) {
  const json* const shown = member(mapping, "variants", json::value_t::array);
  return index_in(mapping, "material", materials) && shown != nullptr &&
         std::all_of(shown->begin(), shown->end(), [&](const json& variant) {
           return variant.is_number_unsigned() && variant.get<std::uint64_t>() < variants;
         });
}

class VariantReader {
 public:
  VariantReader(json& document, MaterialLibrary& library, const json& variants)
      : document_(document), library_(library), count_(library.materials.size()) {
    for (const json& variant : variants)
      variants_.push_back(variant.is_object() ? without_extensions(variant) : json::object());
    taken_.resize(count_);
    mappings_.assign(count_, json::object());
    bytes_ = json_bytes(variants_);
    for (const json* list : {&library.materials, &library.textures, &library.samplers})
      bytes_ += json_bytes(*list);
  }

  /// Returns false if the variants take too much memory; the library is then unchanged.
  bool read() {
    if (bytes_ > kMaxLibraryBytes) return false;
    if (const auto meshes = document_.find("meshes"); meshes != document_.end() && meshes->is_array())
      for (json& mesh : *meshes) {
        const auto primitives = mesh.is_object() ? mesh.find("primitives") : mesh.end();
        if (primitives == mesh.end() || !primitives->is_array()) continue;
        for (json& primitive : *primitives)
          if (!add(mesh, primitive)) return false;
      }
    for (const auto& [primitive, material] : moved_) (*primitive)["material"] = material;
    for (json& material : further_) library_.materials.push_back(std::move(material));
    library_.variants = std::move(variants_);
    if (any_) library_.variant_mappings = std::move(mappings_);
    return true;
  }

  std::vector<Dropped>& dropped() { return dropped_; }

 private:
  /// Gives the primitive a material of the library that stands for its own one and its mappings. Returns false if that takes too
  /// much memory.
  bool add(const json& mesh, json& primitive) {
    if (!primitive.is_object()) return true;
    const std::optional<std::size_t> material = index_in(primitive, "material", count_);
    if (!material) {
      const json* const mappings = list_of(primitive, "mappings");
      if (mappings != nullptr && !mappings->empty()) drop(mesh, "its primitive has no material");
      return true;
    }
    json extension = extension_of(mesh, primitive);
    any_ = any_ || !extension.empty();
    const auto [at, is_new] = known_.try_emplace({*material, extension.dump()}, 0);
    if (is_new && !taken_[*material]) {
      taken_[*material] = true;
      at->second = *material;
      bytes_ += json_bytes(extension);
      mappings_[*material] = std::move(extension);
    } else if (is_new) {
      at->second = mappings_.size();
      json copy = library_.materials[*material];
      bytes_ += json_bytes(extension) + json_bytes(copy);
      mappings_.push_back(std::move(extension));
      further_.push_back(std::move(copy));
    }
    if (at->second != *material) moved_.emplace_back(&primitive, at->second);
    return bytes_ <= kMaxLibraryBytes;
  }

  /// Returns {"mappings": [...]}, or {} if the primitive has none.
  json extension_of(const json& mesh, const json& primitive) {
    json kept = json::array();
    if (const json* const mappings = list_of(primitive, "mappings"))
      for (const json& mapping : *mappings) {
        if (is_sound(mapping, count_, variants_.size())) {
          kept.push_back(without_extensions(mapping));
          continue;
        }
        drop(mesh, "its mapping names a material or a variant that does not exist");
      }
    if (kept.dump().size() > kMostMappings) {
      drop(mesh, "its mappings are too long to be copied to each fragment");
      return json::object();
    }
    return kept.empty() ? json::object() : json{{"mappings", std::move(kept)}};
  }

  void drop(const json& mesh, const char* reason) {
    const json* const name = member(mesh, "name", json::value_t::string);
    dropped_.push_back({"material variant",
                        "a primitive of " + (name != nullptr ? name->get<std::string>() : "a mesh"), reason});
  }

  json& document_;
  MaterialLibrary& library_;
  const std::size_t count_;  // materials of the document
  json variants_ = json::array();
  std::vector<bool> taken_;  // per material of the document: it stands for some mappings
  std::vector<json> mappings_, further_;
  std::map<std::pair<std::size_t, std::string>, std::size_t> known_;
  std::vector<std::pair<json*, std::size_t>> moved_;
  std::vector<Dropped> dropped_;
  std::size_t bytes_ = 0;
  bool any_ = false;
};

}  // namespace

bool has_variants(const json& document) {
  const json* const variants = list_of(document, "variants");
  return variants != nullptr && !variants->empty();
}

void read_variants(json& document, MaterialLibrary& library, std::vector<Dropped>& dropped) {
  if (!has_variants(document)) return;
  const json& variants = *list_of(document, "variants");
  VariantReader reader(document, library, variants);
  if (!reader.read()) {
    for (const json& variant : variants) {
      const json* const name = member(variant, "name", json::value_t::string);
      dropped.push_back({"material variant", name != nullptr ? name->get<std::string>() : "",
                         "the materials and their variants take more than 32 MiB of memory"});
    }
    return;
  }
  std::ranges::move(reader.dropped(), std::back_inserter(dropped));
  library.extensions_used.insert(
      std::lower_bound(library.extensions_used.begin(), library.extensions_used.end(), kName), kName);
}

}  // namespace fracture
