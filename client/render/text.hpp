// Labels on pictures: one line of text from a TrueType font, drawn by the processor. Windows draw their own
// text.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "client/render/image.hpp"

namespace fracture::render {

class Font {
 public:
  /// Opens DejaVu Sans from Debian's fonts-dejavu-core, or another file. kFileAccess if it cannot be read,
  /// kBadImage if it is not a TrueType font.
  static Expected<Font> open(const std::string& path = kDefaultPath);
  Font(Font&&) noexcept;
  Font& operator=(Font&&) noexcept;
  ~Font();

  /// Pixels from the pen's start to its end. Characters beyond Latin-1 are shown as '?'.
  int width(std::string_view text, float pixels) const;
  /// Draws with the baseline at y; `pixels` is the height from ascender to descender.
  void draw(Picture& picture, int x, int y, float pixels, Color color, std::string_view text) const;

  static constexpr const char* kDefaultPath = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

 private:
  struct Face;
  explicit Font(std::unique_ptr<Face> face);
  std::unique_ptr<Face> face_;
};

}  // namespace fracture::render
