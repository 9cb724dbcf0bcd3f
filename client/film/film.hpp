// Turns pictures into a film: a folder of PNG files, or a film made by `ffmpeg`. ffmpeg is never linked. If
// it is installed, it is started as a separate program and receives the pictures through a socket. Every wait
// for it has a time limit.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "client/render/image.hpp"
#include "common/base/error.hpp"

namespace fracture::film {

struct FilmSettings {
  int width = 1280, height = 720;  ///< pixels of every picture
  int rate = 60;                   ///< pictures per second
  std::string program = "ffmpeg";  ///< name or path
  std::chrono::milliseconds patience{
      60000};  ///< for the program to accept a picture, and to end after the last one
};

class Film {
 public:
  /// `path`: ends with .mp4, .gif or .webp, or is a folder, which is created and must not contain an earlier
  /// film. A film at this path is kept until the new one is complete. Fails with kNoProgram if the program
  /// cannot be started, and with kFileAccess if nothing can be written there.
  static Expected<Film> create(const std::string& path, FilmSettings settings);
  Film(Film&&) noexcept;
  ~Film();  ///< stops the program and discards the film if finish() was not called

  /// Fails with kBadParameter if the size differs from the settings. Fails with kNoProgram and the program's
  /// output if it ended or accepted nothing within the patience. In a folder, fails with kFileAccess or
  /// kBadImage.
  Expected<void> add(const render::Picture& picture);
  /// Completes the film. Fails with kNoProgram if the program failed, printed something or wrote no bytes.
  Expected<void> finish();

 private:
  class Program;
  Film(std::string path, FilmSettings settings);
  std::string path_;
  FilmSettings settings_;
  std::string part_;  ///< temporary file that the program writes, next to the path; empty: none
  std::unique_ptr<Program> program_;  ///< null: the pictures go into a folder
  std::size_t frames_ = 0;
};

}  // namespace fracture::film
