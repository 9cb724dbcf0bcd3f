#include "common/import/file_textures.hpp"

#include <utility>

#include "common/base/id.hpp"
#include "common/base/printable.hpp"
#include "common/import/gltf_materials.hpp"
#include "common/import/text_encoding.hpp"
#include "common/import/uri.hpp"

namespace fracture {

std::uint32_t FileTextures::texture(const std::string& path, std::span<const std::uint8_t> embedded) {
  if (const auto it = known_.find(path); it != known_.end()) return it->second;
  Image image;
  if (!embedded.empty()) {
    image.bytes.assign(embedded.begin(), embedded.end());
  } else if (const ImportFile* file = find_file(files_, path)) {
    const auto* begin = reinterpret_cast<const std::uint8_t*>(file->bytes.data());
    image.bytes.assign(begin, begin + file->bytes.size());
  }
  image.mime_type = sniff_image(image.bytes);
  const bool core = image.mime_type == "image/png" || image.mime_type == "image/jpeg";
  if (!core) {
    const std::string name = name_as_utf8(path);
    remarks_.warn(image.bytes.empty()
                      ? in_another_file(name)
                      : "The image \"" + shortened(name) +
                            "\" is neither PNG nor JPEG and was left out. Surfaces that use it have no "
                            "texture in the answer. Convert the image to PNG or JPEG.");
    dropped_.push_back(
        {"image", name, image.bytes.empty() ? "its file was not given" : "it is neither PNG nor JPEG"});
    return known_[path] = kNoIndex;
  }
  image.name = name_as_utf8(path.substr(path.find_last_of("/\\") + 1));
  nlohmann::json& textures = library_.textures;
  textures.push_back({{"source", library_.images.size()}});
  library_.images.push_back(std::move(image));
  return known_[path] = static_cast<std::uint32_t>(textures.size() - 1);
}

}  // namespace fracture
