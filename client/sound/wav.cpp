#include "client/sound/wav.hpp"

#include <cmath>
#include <filesystem>
#include <limits>

#include "client/sound/clip.hpp"

namespace fracture::sound {
namespace {

constexpr std::uint32_t kHeader = 44, kFrame = 4;  // bytes: header; one frame of both channels

void put(std::string& text, std::uint32_t value, int bytes) {
  for (int k = 0; k < bytes; ++k) text += static_cast<char>((value >> (8 * k)) & 0xff);
}

std::string header(std::uint32_t bytes) {
  std::string text = "RIFF";
  put(text, bytes + kHeader - 8, 4);
  text += "WAVEfmt ";
  put(text, 16, 4);
  put(text, 1, 2);  // PCM
  put(text, 2, 2);  // channels
  put(text, kRate, 4);
  put(text, kRate * kFrame, 4);
  put(text, kFrame, 2);
  put(text, 16, 2);  // bits
  text += "data";
  put(text, bytes, 4);
  return text;
}

}  // namespace

Expected<WavFile> WavFile::create(const std::string& path) {
  // Opening a pipe would also block until somebody reads from it.
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::is_fifo(status) || std::filesystem::is_socket(status))
    return fail(ErrorCode::kFileAccess,
                "Cannot write " + path +
                    ". It is a pipe, but the header of a WAV file is written last. Specify a file.");
  std::ofstream out(path, std::ios::binary);
  out << header(0);
  if (!out.flush()) return fail(ErrorCode::kFileAccess, "Cannot write " + path + ".");
  return WavFile(std::move(out));
}

void WavFile::add(std::span<const float> samples) {
  std::string bytes;
  bytes.reserve(2 * samples.size());
  for (const float x : samples) {
    const double bent = x / std::sqrt(std::sqrt(1 + std::pow(static_cast<double>(x), 4)));
    put(bytes, static_cast<std::uint16_t>(std::lround(32767 * bent)), 2);
  }
  // The format has 32-bit lengths, so samples beyond them (six hours) are left out.
  if (bytes.size() > std::numeric_limits<std::uint32_t>::max() - kHeader - bytes_) return;
  out_ << bytes;
  bytes_ += static_cast<std::uint32_t>(bytes.size());
}

bool WavFile::finish() {
  out_.seekp(0);
  out_ << header(bytes_);
  out_.close();
  return !out_.fail();
}

}  // namespace fracture::sound
