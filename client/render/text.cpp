#include "client/render/text.hpp"

#include <stb/stb_truetype.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

namespace fracture::render {

struct Font::Face {
  std::vector<unsigned char> file;
  stbtt_fontinfo info{};
};

namespace {

/// The next character as Latin-1 ('?' for anything beyond). Invalid UTF-8 is read byte by byte.
int next_character(std::string_view& text) {
  const auto byte = static_cast<unsigned char>(text.front());
  text.remove_prefix(1);
  if (byte < 0x80) return byte;
  int length = byte >= 0xf0 ? 3 : byte >= 0xe0 ? 2 : 1;
  int character = byte & (0x3f >> length);
  while (length-- > 0 && !text.empty() && (static_cast<unsigned char>(text.front()) & 0xc0) == 0x80) {
    character = character << 6 | (static_cast<unsigned char>(text.front()) & 0x3f);
    text.remove_prefix(1);
  }
  return character <= 0xff ? character : '?';
}

}  // namespace

Font::Font(std::unique_ptr<Face> face) : face_(std::move(face)) {}
Font::Font(Font&&) noexcept = default;
Font& Font::operator=(Font&&) noexcept = default;
Font::~Font() = default;

Expected<Font> Font::open(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  auto face = std::make_unique<Face>();
  if (in) face->file.assign(std::istreambuf_iterator<char>(in), {});
  if (face->file.empty())
    return fail(ErrorCode::kFileAccess, "Labels need the font " + path + " (Debian: fonts-dejavu-core).");
  // stb_truetype trusts its file, so fonts come from the system, never from a request.
  const int offset = stbtt_GetFontOffsetForIndex(face->file.data(), 0);
  if (offset < 0 || stbtt_InitFont(&face->info, face->file.data(), offset) == 0)
    return fail(ErrorCode::kBadImage, path + " is not a TrueType font.");
  return Font(std::move(face));
}

int Font::width(std::string_view text, float pixels) const {
  const float scale = stbtt_ScaleForPixelHeight(&face_->info, pixels);
  float pen = 0;
  while (!text.empty()) {
    int advance = 0, bearing = 0;
    stbtt_GetCodepointHMetrics(&face_->info, next_character(text), &advance, &bearing);
    pen += scale * static_cast<float>(advance);
  }
  return static_cast<int>(std::ceil(pen));
}

void Font::draw(Picture& picture, int x, int y, float pixels, Color color, std::string_view text) const {
  const float scale = stbtt_ScaleForPixelHeight(&face_->info, pixels);
  float pen = static_cast<float>(x);
  while (!text.empty()) {
    const int character = next_character(text);
    const float fraction = pen - std::floor(pen);
    int advance = 0, bearing = 0, x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    stbtt_GetCodepointHMetrics(&face_->info, character, &advance, &bearing);
    stbtt_GetCodepointBitmapBoxSubpixel(&face_->info, character, scale, scale, fraction, 0, &x0, &y0, &x1,
                                        &y1);
    const int w = x1 - x0, h = y1 - y0;
    if (w > 0 && h > 0) {
      std::vector<unsigned char> glyph(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
      stbtt_MakeCodepointBitmapSubpixel(&face_->info, glyph.data(), w, h, w, scale, scale, fraction, 0,
                                        character);
      for (int row = 0; row < h; ++row)
        for (int column = 0; column < w; ++column) {
          const int px = static_cast<int>(std::floor(pen)) + x0 + column, py = y + y0 + row;
          if (px < 0 || py < 0 || px >= picture.width || py >= picture.height) continue;
          const int cover = glyph[static_cast<std::size_t>(row) * static_cast<std::size_t>(w) +
                                  static_cast<std::size_t>(column)];
          Color& out = picture.at(px, py);
          for (std::size_t k = 0; k < 3; ++k)
            out[k] = static_cast<std::uint8_t>((out[k] * (255 - cover) + color[k] * cover + 127) / 255);
        }
    }
    pen += scale * static_cast<float>(advance);
  }
}

}  // namespace fracture::render
