#include "client/render/image.hpp"

#include <stb/stb_image.h>
#include <stb/stb_image_write.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <string_view>
#include <system_error>

#include "common/base/atomic_file.hpp"
#include "common/base/srgb.hpp"

namespace fracture::render {
namespace {

/// Table from a byte to linear light.
std::array<float, 256> linear_table() {
  std::array<float, 256> table{};
  for (std::size_t k = 0; k < table.size(); ++k)
    table[k] = static_cast<float>(linear_of_srgb(static_cast<double>(k) / 255.0));
  return table;
}

std::uint8_t srgb_byte(float linear) {
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(srgb_of_linear(linear), 0.0, 1.0)));
}

}  // namespace

Expected<Picture> decode_picture(std::span<const std::uint8_t> bytes) {
  int width = 0, height = 0, channels = 0;
  const int size = static_cast<int>(bytes.size());
  if (bytes.size() > 0x7fffffff || stbi_info_from_memory(bytes.data(), size, &width, &height, &channels) == 0)
    return fail(ErrorCode::kBadImage, "The image is neither PNG nor JPEG.");
  if (width < 1 || height < 1 || width > kMaxPictureSide || height > kMaxPictureSide)
    return fail(ErrorCode::kTooLarge, "The image has " + std::to_string(width) + " x " +
                                          std::to_string(height) + " pixels; the maximum for a side is " +
                                          std::to_string(kMaxPictureSide) + ".");
  const std::unique_ptr<stbi_uc, void (*)(void*)> data(
      stbi_load_from_memory(bytes.data(), size, &width, &height, &channels, 4), stbi_image_free);
  if (!data)
    return fail(ErrorCode::kBadImage, std::string("The image is damaged: ") + stbi_failure_reason() + ".");
  Picture picture(width, height);
  std::memcpy(picture.pixels.data(), data.get(), picture.pixels.size() * sizeof(Color));
  return picture;
}

Expected<void> may_write_png(const std::string& path) {
  namespace fs = std::filesystem;
  const auto cannot = [&](int why) {
    return fail(ErrorCode::kFileAccess, "Cannot write " + path + ": " + std::strerror(why) + ".");
  };
  std::error_code error;
  const fs::file_status there = fs::status(path, error);
  if (fs::is_directory(there)) return cannot(EISDIR);
  if (fs::exists(there)) {
    if (!fs::is_regular_file(there))
      return fail(ErrorCode::kBadParameter,
                  path + " is not a regular file. Choose another path for the picture.");
    constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);
    std::array<char, kSignature.size()> head{};
    std::ifstream file(path, std::ios::binary);
    file.read(head.data(), head.size());
    if (!file.is_open() || (file.gcount() > 0 && std::string_view(head.data(), head.size()) != kSignature))
      return fail(ErrorCode::kBadParameter,
                  path + " exists and is not a PNG. Move it, or choose another path for the picture.");
  }
  AtomicFile tried;
  if (!tried.open(path)) return cannot(errno);
  return {};
}

Expected<void> write_png(const Picture& picture, const std::string& path) {
  if (Expected<void> may = may_write_png(path); !may) return may;
  if (picture.width < 1 || picture.height < 1)
    return fail(ErrorCode::kBadImage, "The picture to be written to " + path + " is empty.");
  std::vector<std::uint8_t> rgb(3 * picture.pixels.size());
  for (std::size_t k = 0; k < picture.pixels.size(); ++k)
    std::copy_n(picture.pixels[k].begin(), 3, rgb.begin() + static_cast<std::ptrdiff_t>(3 * k));
  std::vector<std::uint8_t> png;
  const auto append = [](void* to, void* data, int size) {
    auto& out = *static_cast<std::vector<std::uint8_t>*>(to);
    const auto* at = static_cast<const std::uint8_t*>(data);
    out.insert(out.end(), at, at + size);
  };
  if (stbi_write_png_to_func(append, &png, picture.width, picture.height, 3, rgb.data(), 3 * picture.width) ==
      0)
    return fail(ErrorCode::kBadImage, "The picture for " + path + " cannot be encoded.");

  // Not flushed, because a film of pictures would wait for the disk at every frame.
  if (!write_atomically(path, std::as_bytes(std::span(png)), {.flushed = false}))
    return fail(ErrorCode::kFileAccess, "Cannot write " + path + ": " + std::strerror(errno) + ".");
  return {};
}

void paste(Picture& to, const Picture& from, int x, int y) {
  const int first = std::max(0, -x), last = std::min(from.width, to.width - x);
  if (first >= last) return;
  for (int row = std::max(0, -y); row < std::min(from.height, to.height - y); ++row)
    std::copy(&from.at(first, row), &from.at(last - 1, row) + 1, &to.at(x + first, y + row));
}

Picture downsample(const Picture& picture, int factor) {
  if (factor <= 1) return picture;
  static const std::array<float, 256> linear = linear_table();
  Picture small(picture.width / factor, picture.height / factor);
  const float weight = 1.0f / static_cast<float>(factor * factor);
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x) {
      std::array<float, 4> sum{};
      for (int j = 0; j < factor; ++j)
        for (int i = 0; i < factor; ++i) {
          const Color& c = picture.at(factor * x + i, factor * y + j);
          for (std::size_t k = 0; k < 3; ++k) sum[k] += linear[c[k]];
          sum[3] += static_cast<float>(c[3]);
        }
      Color& out = small.at(x, y);
      for (std::size_t k = 0; k < 3; ++k) out[k] = srgb_byte(weight * sum[k]);
      out[3] = static_cast<std::uint8_t>(std::lround(weight * sum[3]));
    }
  return small;
}

}  // namespace fracture::render
