#include "common/import/import.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "common/import/assimp_import.hpp"
#include "common/import/complete_attributes.hpp"
#include "common/import/gltf_import.hpp"
#include "common/import/gzip.hpp"
#include "common/import/preflight.hpp"
#include "common/import/text_encoding.hpp"

namespace fracture {
namespace {

struct FormatRow {
  MeshFormat format;
  const char* extension;
  bool enabled_by_default;
  std::array<const char*, 3> media_types;
};

constexpr std::array kFormats = {
    FormatRow{MeshFormat::kGlb, "glb", true, {"model/gltf-binary", nullptr, nullptr}},
    FormatRow{MeshFormat::kGltf, "gltf", true, {"model/gltf+json", nullptr, nullptr}},
    FormatRow{MeshFormat::kObj, "obj", true, {"model/obj", "text/prs.wavefront-obj", nullptr}},
    FormatRow{MeshFormat::kStl, "stl", true, {"model/stl", "application/sla", "application/vnd.ms-pki.stl"}},
    FormatRow{MeshFormat::kPly, "ply", true, {"model/ply", "application/ply", nullptr}},
    FormatRow{MeshFormat::kOff, "off", true, {"model/off", "model/vnd.off", nullptr}},
    FormatRow{MeshFormat::kBlend, "blend", false, {"application/x-blender", nullptr, nullptr}},
    FormatRow{MeshFormat::kFbx, "fbx", false, {"model/fbx", "application/vnd.autodesk.fbx", nullptr}},
    FormatRow{MeshFormat::kDae, "dae", false, {"model/vnd.collada+xml", nullptr, nullptr}},
    FormatRow{MeshFormat::k3ds, "3ds", false, {"application/x-3ds", "image/x-3ds", nullptr}},
};

const FormatRow& row(MeshFormat format) {
  return *std::find_if(kFormats.begin(), kFormats.end(),
                       [&](const FormatRow& r) { return r.format == format; });
}

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [&](char x, char y) { return lower(x) == lower(y); });
}

Expected<void> preflight_of(std::span<const std::byte> bytes, MeshFormat format, const ImportLimits& limits) {
  switch (format) {
    case MeshFormat::kGlb:
    case MeshFormat::kGltf:
      return {};  // the glTF reader's own first step: it needs the chunks
    case MeshFormat::kObj:
      return preflight::check_obj(bytes, limits);
    case MeshFormat::kStl:
      return preflight::check_stl(bytes, limits);
    case MeshFormat::kPly:
      return preflight::check_ply(bytes, limits);
    case MeshFormat::kOff:
      return preflight::check_off(bytes, limits);
    default:
      return preflight::check_magic(bytes, format);
  }
}

/// What the format says where the file cannot (FBX says it itself, its reader fills the frame in).
void state_frame(Mesh& mesh, MeshFormat format) {
  switch (format) {
    case MeshFormat::kGlb:
    case MeshFormat::kGltf:  // glTF 2.0, section 3.4
    case MeshFormat::kDae:   // Assimp applies <unit> and <up_axis> to the root
      mesh.frame.metres_stated = mesh.frame.up_stated = true;
      break;
    case MeshFormat::k3ds:  // z up by convention, turned by Assimp
      mesh.frame.up_stated = true;
      break;
    case MeshFormat::kBlend:
      mesh.frame.z_up = mesh.frame.up_stated = true;
      break;
    default:
      break;
  }
}

}  // namespace

std::optional<MeshFormat> format_from_extension(std::string_view extension) {
  for (const FormatRow& r : kFormats)
    if (equal_ignoring_case(extension, r.extension)) return r.format;
  return std::nullopt;
}

std::optional<MeshFormat> format_from_media_type(std::string_view media_type) {
  media_type = media_type.substr(0, media_type.find(';'));
  while (!media_type.empty() && media_type.back() == ' ') media_type.remove_suffix(1);
  for (const FormatRow& r : kFormats)
    for (const char* known : r.media_types)
      if (known != nullptr && equal_ignoring_case(media_type, known)) return r.format;
  return std::nullopt;
}

const char* extension_of(MeshFormat format) { return row(format).extension; }

bool enabled_by_default(MeshFormat format) { return row(format).enabled_by_default; }

Expected<Mesh> import_mesh(std::span<const std::byte> bytes, MeshFormat format, const ImportLimits& limits,
                           std::span<const ImportFile> files) {
  if (bytes.empty()) return fail(ErrorCode::kEmptyBody, "The mesh has no bytes.");
  const bool text = format == MeshFormat::kObj || format == MeshFormat::kOff || format == MeshFormat::kDae;
  std::optional<std::string> converted;
  if (text) converted = utf16_to_utf8(bytes);
  if (converted) bytes = std::as_bytes(std::span(*converted));
  std::vector<std::byte> inflated;
  if (format == MeshFormat::kBlend && is_gzip(bytes)) {
    auto plain = gunzip(bytes, limits.max_decoded_bytes);
    if (!plain) return tl::unexpected<Error>(plain.error());
    inflated = std::move(*plain);
    bytes = inflated;
  }
  if (auto checked = preflight_of(bytes, format, limits); !checked)
    return tl::unexpected<Error>(checked.error());
  const bool gltf = format == MeshFormat::kGlb || format == MeshFormat::kGltf;
  Expected<Mesh> mesh =
      gltf ? import_gltf(bytes, format, limits, files) : import_with_assimp(bytes, format, limits, files);
  if (mesh) state_frame(*mesh, format);
  if (mesh)  // they quote the file, cut to a length that may end within a character
    for (std::string& warning : mesh->warnings) warning = name_as_utf8(warning);
  if (mesh) complete_attributes(*mesh);
  return mesh;
}

}  // namespace fracture
