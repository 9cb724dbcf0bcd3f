#include "common/surface_color/webp.hpp"

#include <webp/decode.h>

#include <cstdlib>
#include <cstring>
#include <new>

namespace fracture {
namespace {

using Bytes = std::span<const std::uint8_t>;

std::optional<WebPBitstreamFeatures> features_of(Bytes webp) {
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(webp.data(), webp.size(), &features) != VP8_STATUS_OK) return std::nullopt;
  if (features.has_animation != 0 || features.width < 1 || features.height < 1) return std::nullopt;
  return features;
}

}  // namespace

bool is_webp(Bytes image) {
  return image.size() >= 12 && std::memcmp(image.data(), "RIFF", 4) == 0 &&
         std::memcmp(image.data() + 8, "WEBP", 4) == 0;
}

std::optional<std::uint64_t> webp_pixel_count(Bytes webp) {
  const auto features = features_of(webp);
  if (!features) return std::nullopt;
  return static_cast<std::uint64_t>(features->width) * static_cast<std::uint64_t>(features->height);
}

std::optional<Pixels> decode_webp(Bytes webp) {
  const auto features = features_of(webp);
  WebPDecoderConfig config;
  if (!features || WebPInitDecoderConfig(&config) == 0) return std::nullopt;
  const auto width = static_cast<std::uint32_t>(features->width),
             height = static_cast<std::uint32_t>(features->height);
  const std::size_t bytes = std::size_t{4} * width * height;
  auto* const values = static_cast<std::uint8_t*>(std::malloc(bytes));
  if (values == nullptr) throw std::bad_alloc();
  Pixels pixels(width, height, values);
  config.output.colorspace = MODE_RGBA;
  config.output.is_external_memory = 1;
  config.output.u.RGBA = {values, static_cast<int>(4 * width), bytes};
  const VP8StatusCode status = WebPDecode(webp.data(), webp.size(), &config);
  WebPFreeDecBuffer(&config.output);
  if (status == VP8_STATUS_OUT_OF_MEMORY) throw std::bad_alloc();
  if (status != VP8_STATUS_OK) return std::nullopt;
  return pixels;
}

}  // namespace fracture
