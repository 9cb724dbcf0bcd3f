// Fuzz target: the first byte chooses the format (in the order of formats.def), the rest is the file. The
// target is all of our code that handles a file before a foreign reader does: decompression, text encoding,
// the checks of its format. It also includes the search for files that a file refers to, because those names
// come from the same bytes.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "common/base/utf8.hpp"
#include "common/import/decompress.hpp"
#include "common/import/preflight.hpp"
#include "common/import/sibling_files.hpp"
#include "common/import/text_encoding.hpp"
#include "common/import/uri.hpp"

namespace {

template <class T>
void has_words(const fracture::Expected<T>& result) {
  if (!result && (result.error().detail.empty() || result.error().detail.size() > 2000)) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture;
  if (size < 1) return 0;
  const std::span<const std::byte> file{reinterpret_cast<const std::byte*>(data + 1), size - 1};
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  const auto format = static_cast<MeshFormat>(data[0] % all_formats().size());
  ImportLimits limits;
  limits.max_triangles = 1000;
  limits.max_decoded_bytes = 1u << 20;
  constexpr std::uint32_t kDepth = 64;
  (void)format_from_content(file);
  (void)referenced_files(file, format);
  switch (format) {
    case MeshFormat::kGlb:
      has_words(preflight::split_glb(file));
      break;
    case MeshFormat::kGltf:
      has_words(preflight::check_json_depth(text, kDepth));
      break;
    case MeshFormat::kObj:
      (void)textures_of_mtl(text);
      break;
    case MeshFormat::k3mf:
    case MeshFormat::kZae:
      has_words(preflight::check_zip(file, limits));
      break;
    case MeshFormat::kZgl:
      has_words(inflate(file, limits.max_decoded_bytes));
      break;
    case MeshFormat::kAssbin:
      has_words(unzstd(file, limits.max_decoded_bytes));
      break;
    case MeshFormat::kXml:
      has_words(preflight::kind_of_xml(file));
      has_words(preflight::check_xml_depth(file));
      if (const auto converted = utf16_to_utf8(file); converted && !is_utf8(*converted)) std::abort();
      if (!is_utf8(name_as_utf8(text))) std::abort();
      (void)decode_data_uri(text);
      break;
    default:
      has_words(preflight::check_magic(file, format));
  }
  return 0;
}
