#include "server/bake/mesh_names.hpp"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <utility>

#include "common/import/gltf_entries.hpp"
#include "common/import/obj_lines.hpp"

namespace fracture::bake {
namespace {

/// Collects names up to the limits.
class Collected {
 public:
  /// Returns false if a limit is exceeded.
  bool add(std::set<std::string> MeshNames::*list, std::string_view name) {
    if (name.empty() || !(names_.*list).emplace(name).second) return true;
    bytes_ += name.size();
    full_ = full_ || ++count_ > kMaxMeshNames || bytes_ > kMaxMeshNameBytes;
    return !full_;
  }
  bool full() const { return full_; }
  MeshNames take() && { return std::move(names_); }

 private:
  MeshNames names_;
  std::size_t count_ = 0, bytes_ = 0;
  bool full_ = false;
};

/// Returns false if the bytes are not JSON or contain too many names.
bool read_gltf(std::string_view bytes, Collected& names) {
  return read_gltf_entries(bytes, "name", [&](const std::string& list, std::string& name) {
    if (list == "nodes" || list == "meshes") return names.add(&MeshNames::nodes, name);
    return list != "materials" || names.add(&MeshNames::materials, name);
  });
}

constexpr std::string_view kSpace = " \t\r\f";

std::string_view trimmed(std::string_view text) {
  text.remove_prefix(std::min(text.size(), text.find_first_not_of(kSpace)));
  return text.substr(0, text.find_last_not_of(kSpace) + 1);
}

void read_obj(std::string_view text, Collected& names) {
  ObjLines lines(text);
  std::string material;  // for the next faces; stored once a face uses it
  for (std::string_view line; !names.full() && lines.next(line);) {
    line = trimmed(line);
    const std::size_t end = line.find_first_of(kSpace);
    if (end == std::string_view::npos) continue;
    const std::string_view word = line.substr(0, end), rest = trimmed(line.substr(end));
    if (word == "o" || word == "g")
      names.add(&MeshNames::nodes, rest);
    else if (word == "usemtl")
      material = rest;
    else if (word == "f" && !material.empty())
      names.add(&MeshNames::materials, std::exchange(material, {}));
  }
}

}  // namespace

Expected<MeshNames> names_in(const std::string& path, std::span<const std::byte> bytes,
                             std::optional<MeshFormat> given) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::optional<MeshFormat> format = given;
  if (!format)
    if (const std::string ending = std::filesystem::path(path).extension().string(); ending.size() > 1)
      format = format_from_extension(ending.substr(1));
  if (!format) format = format_from_content(bytes);
  Collected names;
  const bool gltf = format == MeshFormat::kGlb || format == MeshFormat::kGltf;
  const bool read = !gltf || read_gltf(text, names);
  if (format == MeshFormat::kObj) read_obj(text, names);
  if (names.full())
    return fail(ErrorCode::kTooLarge, "With rules for nodes or materials, a mesh may have at most " +
                                          std::to_string(kMaxMeshNames) + " names with " +
                                          std::to_string(kMaxMeshNameBytes) +
                                          " bytes in total; this mesh has more.");
  return read ? std::move(names).take() : MeshNames{};
}

}  // namespace fracture::bake
