// Writes a sound file incrementally.
#pragma once

#include <cstdint>
#include <fstream>
#include <span>
#include <string>

#include "common/base/error.hpp"

namespace fracture::sound {

/// RIFF WAVE, 16-bit PCM, stereo at kRate. The lengths in the header are valid after finish().
class WavFile {
 public:
  /// kFileAccess.
  static Expected<WavFile> create(const std::string& path);
  /// Left and right interleaved; 1 is full scale. Loud samples are not clipped but compressed by x / (1 +
  /// x⁴)^(1/4), which changes values up to a quarter of full scale by at most a thousandth and never reaches
  /// 1.
  void add(std::span<const float> samples);
  /// Whether the file is complete; false on a full disk, for example.
  bool finish();

 private:
  explicit WavFile(std::ofstream out) : out_(std::move(out)) {}
  std::ofstream out_;
  std::uint32_t bytes_ = 0;
};

}  // namespace fracture::sound
