// The materials of an OBJ and its material libraries (MTL).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/remarks.hpp"
#include "common/import/import_input.hpp"
#include "common/import/plain_materials.hpp"
#include "common/mesh/dropped.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture {

/// Collects materials in the order in which the statements of the OBJ name or load them. A material that no library defines
/// has the grey that readers of OBJ use for such materials. Each file is read once, so time is linear in the files.
class ObjMaterials {
 public:
  explicit ObjMaterials(std::span<const ImportFile> files) : files_(files) {}

  /// `mtllib`, with the text after it: reads the libraries. If a name is not among the files, but there is exactly one MTL
  /// file, that file is meant. Throws Refused (kTooLarge).
  void load(std::string_view rest);
  /// `usemtl`, with the name: returns the number of the material, or kNoIndex for the name that means "none". Throws Refused
  /// (kTooLarge).
  std::uint32_t use(std::string_view name);
  std::size_t size() const { return materials_.size(); }

  /// Converts the materials to glTF's, in the order of their numbers. `used`, for each number: a face has the material. Adds
  /// a warning about libraries that were not given, and lists textures that are left out. Throws Refused (kTooLarge).
  MaterialLibrary finish(const std::vector<bool>& used, Remarks& remarks, std::vector<Dropped>& dropped);

 private:
  struct Map {
    std::string keyword, file;
  };
  struct Material {
    PlainMaterial plain;
    bool defined = false;               ///< by a library
    std::vector<Map> left_out{};        ///< textures that glTF cannot have
    std::vector<std::string> placed{};  ///< textures with a placement
  };

  std::uint32_t number_of_name(std::string_view name);
  void count(std::size_t bytes);
  const ImportFile* find(const std::string& name) const;
  void read(const ImportFile& file, const std::string& name);
  bool set_value(Material& material, const std::string& keyword, std::string_view rest);
  void set_map(Material& material, const std::string& keyword, std::string_view rest,
               const std::string& folder);
  void warn_about_libraries(const std::vector<bool>& used, Remarks& remarks) const;

  std::span<const ImportFile> files_;
  std::vector<Material> materials_;
  std::map<std::string, std::uint32_t, std::less<>> numbers_;
  std::set<std::string> asked_;  ///< names of libraries
  std::set<const ImportFile*> read_;
  std::vector<std::string> missing_;  ///< libraries that were not given
  std::size_t bytes_ = 0;
  std::string unreadable_;  ///< the first statement of a library that is not as MTL defines it, and its place
  std::uint64_t unreadable_count_ = 0;
};

}  // namespace fracture
