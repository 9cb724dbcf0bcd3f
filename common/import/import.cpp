#include "common/import/import.hpp"

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/json_reader.hpp"
#include "common/base/words.hpp"
#include "common/import/assimp_import.hpp"
#include "common/import/complete_attributes.hpp"
#include "common/import/decompress.hpp"
#include "common/import/gltf_import.hpp"
#include "common/import/obj_import.hpp"
#include "common/import/off_import.hpp"
#include "common/import/ply_import.hpp"
#include "common/import/preflight.hpp"
#include "common/import/stl_import.hpp"
#include "common/import/text_encoding.hpp"
#include "common/import/threemf_import.hpp"
#include "common/mesh/material_library.hpp"
#include "common/surface_color/surface_colors.hpp"

namespace fracture {
namespace {

/// The file in the form that its parser needs: text in UTF-8, and without whole-file compression. `format` is
/// the actual one.
struct PlainFile {
  std::span<const std::byte> bytes;
  MeshFormat format;
  std::string text;
  std::vector<std::byte> inflated;
};

Expected<PlainFile> make_plain(std::span<const std::byte> bytes, MeshFormat format,
                               const ImportLimits& limits) {
  PlainFile file{bytes, format, {}, {}};
  const bool zgl = format == MeshFormat::kZgl, blend = format == MeshFormat::kBlend;
  if (zgl || (blend && (is_gzip(bytes) || is_zstd(bytes)))) {
    auto plain = blend && is_zstd(bytes) ? unzstd(bytes, limits.max_decoded_bytes)
                                         : inflate(bytes, limits.max_decoded_bytes);
    if (!plain) return tl::unexpected<Error>(plain.error());
    file.inflated = std::move(*plain);
    file.bytes = file.inflated;
    if (zgl) file.format = MeshFormat::kXgl;
  }
  if (format_info(file.format).encoding != FormatEncoding::kBinary &&
      format_info(file.format).reader != FormatReader::kTinygltf) {
    if (std::optional<std::string> text = utf16_to_utf8(file.bytes)) {
      file.text = std::move(*text);
      file.bytes = std::as_bytes(std::span(file.text));
    }
  }
  if (file.format == MeshFormat::kXml) {
    const Expected<MeshFormat> kind = preflight::kind_of_xml(file.bytes);
    if (!kind) return tl::unexpected<Error>(kind.error());
    file.format = *kind;
  }
  return file;
}

Expected<void> preflight_of(std::span<const std::byte> bytes, MeshFormat format, const ImportLimits& limits) {
  switch (format) {
    case MeshFormat::kGlb:
    case MeshFormat::kGltf:
    case MeshFormat::kObj:
    case MeshFormat::kStl:
    case MeshFormat::kPly:
    case MeshFormat::kOff:
      return {};  // their readers do this themselves
    case MeshFormat::k3mf:
    case MeshFormat::kIfczip:
    case MeshFormat::kPk3:
    case MeshFormat::kZae:
      return preflight::check_zip(bytes, limits);
    default:
      if (format_info(format).encoding == FormatEncoding::kXml)
        if (auto checked = preflight::check_xml_depth(bytes); !checked) return checked;
      return preflight::check_magic(bytes, format);
  }
}

Expected<Mesh> read(const PlainFile& file, const ImportLimits& limits, std::span<const ImportFile> files) {
  switch (format_info(file.format).reader) {
    case FormatReader::kTinygltf:
      return import_gltf(file.bytes, file.format, limits, files);
    case FormatReader::kOwn:
      if (file.format == MeshFormat::kObj) return import_obj(file.bytes, limits, files);
      if (file.format == MeshFormat::kStl) return import_stl(file.bytes, limits);
      if (file.format == MeshFormat::kPly) return import_ply(file.bytes, limits, files);
      if (file.format == MeshFormat::kOff) return import_off(file.bytes, limits);
      if (file.format == MeshFormat::k3mf) return import_3mf(file.bytes, limits);
      break;
    case FormatReader::kAssimp:
      return import_with_assimp(file.bytes, file.format, limits, files);
  }
  throw InternalError("a mesh format without a reader");
}

/// Sets the frame that the format defines, if the file cannot state it. (FBX files state it, and their reader
/// sets it.)
void state_frame(Mesh& mesh, FormatFrame frame) {
  if (frame == FormatFrame::kUnknown) return;
  mesh.frame.up_stated = true;
  mesh.frame.z_up = frame == FormatFrame::kZUp;
  mesh.frame.metres_stated = frame == FormatFrame::kMetresYUp;
}

/// Refuses materials that the server would not accept from the process that reads the file. Readers of formats in which
/// materials are numerous have their own limits, which are lower.
Expected<void> limit_materials(const MaterialLibrary& library) {
  constexpr std::size_t kMost = kMaxLibraryBytes / 2 * 3;
  for (const nlohmann::json* list : json_lists(library))
    if (json_bytes(*list) > kMost)
      return fail(ErrorCode::kTooLarge,
                  "The materials take more than " + data_size(kMost) +
                      " of memory, which is the limit. Merge materials that look the same.",
                  {}, {{"limit", kMost}});
  return {};
}

}  // namespace

Expected<Mesh> import_mesh(std::span<const std::byte> bytes, MeshFormat format, const ImportLimits& limits,
                           std::span<const ImportFile> files) {
  if (bytes.empty()) return fail(ErrorCode::kEmptyBody, "The mesh has no bytes.");
  if (const FormatInfo& info = format_info(format); *info.without_surface != 0)
    return fail(ErrorCode::kEmptyMesh, "A ." + std::string(info.name) + " file contains " +
                                           info.without_surface + ", not a surface that could be fractured.");
  const Expected<PlainFile> plain = make_plain(bytes, format, limits);
  if (!plain) return tl::unexpected<Error>(plain.error());
  if (auto checked = preflight_of(plain->bytes, plain->format, limits); !checked)
    return tl::unexpected<Error>(checked.error());
  Expected<Mesh> mesh = read(*plain, limits, files);
  if (!mesh) return mesh;
  if (auto limited = limit_materials(*mesh->library); !limited) return tl::unexpected<Error>(limited.error());
  state_frame(*mesh, format_info(plain->format).frame);
  for (auto* list : {&mesh->remarks.warnings, &mesh->remarks.notes})
    for (std::string& sentence :
         *list)  // they quote the file, shortened to a length that may divide a character
      sentence = name_as_utf8(sentence);
  for (Dropped& entry : mesh->dropped) entry.name = name_as_utf8(entry.name);
  shorten_dropped(mesh->dropped);
  complete_attributes(*mesh);
  mesh->triangle_color = surface_colors(*mesh, mesh->remarks);
  return mesh;
}

}  // namespace fracture
