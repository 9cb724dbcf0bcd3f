// Pictures as a film: a folder of PNG files, or what `ffmpeg` makes of them. It is started as a program of its own where it
// is installed, never linked, and is given the pictures through a socket. Every wait for it ends.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "client/render/image.hpp"
#include "common/base/error.hpp"

namespace fracture::film {

struct FilmSettings {
  int width = 1280, height = 720;  ///< pixels, of every picture
  int rate = 60;                   ///< pictures a second
  std::string program = "ffmpeg";  ///< by its name or path
  std::chrono::milliseconds patience{
      60000};  ///< for the program to take a picture, and to end after the last
};

class Film {
 public:
  /// `path`: ends with .mp4, .gif or .webp, or is a folder, which is made, and has no pictures of an earlier film. What lies
  /// at the path of a film stays until the new one is whole. kNoProgram where the program cannot be started, kFileAccess
  /// where nothing can be written there.
  static Expected<Film> create(const std::string& path, FilmSettings settings);
  Film(Film&&) noexcept;
  ~Film();  ///< without finish(): the program is ended, and there is no new film

  /// Not of the settings' size: kBadParameter. kNoProgram with what the program said where it ended, or took nothing for as
  /// long as patience lasts; kFileAccess, kBadImage in a folder.
  Expected<void> add(const render::Picture& picture);
  /// The film is complete, or what became of it: kNoProgram where the program failed, had something to say or left no bytes.
  Expected<void> finish();

 private:
  class Program;
  Film(std::string path, FilmSettings settings);
  std::string path_;
  FilmSettings settings_;
  std::string part_;                  ///< what the program writes, beside the path; empty: nothing
  std::unique_ptr<Program> program_;  ///< null: a folder
  std::size_t frames_ = 0;
};

}  // namespace fracture::film
