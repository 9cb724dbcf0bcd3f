// A sound as a file, while it is made.
#pragma once

#include <cstdint>
#include <fstream>
#include <span>
#include <string>

#include "common/base/error.hpp"

namespace fracture::sound {

/// RIFF WAVE, 16-bit PCM, stereo at kRate. The header's lengths stand in it after finish().
class WavFile {
 public:
  /// kFileAccess.
  static Expected<WavFile> create(const std::string& path);
  /// Left and right in turn, 1 is full scale. Nothing is clipped: what is loud is bent, x / (1 + x⁴)^(1/4), which leaves a
  /// quarter of full scale as it is to a thousandth and never reaches 1.
  void add(std::span<const float> samples);
  /// Whether all of it is in the file; false on a full disk, say.
  bool finish();

 private:
  explicit WavFile(std::ofstream out) : out_(std::move(out)) {}
  std::ofstream out_;
  std::uint32_t bytes_ = 0;
};

}  // namespace fracture::sound
