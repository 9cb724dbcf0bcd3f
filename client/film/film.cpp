#include "client/film/film.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "common/base/descriptor.hpp"
#include "common/base/spawn.hpp"
#include "common/base/wait_for.hpp"

namespace fracture::film {
namespace {

using Clock = std::chrono::steady_clock;

/// The file extension of a film, or null if the path is not a film.
const char* ending_of(const std::string& path) {
  for (const char* ending : {".mp4", ".gif", ".webp"})
    if (path.ends_with(ending)) return ending;
  return nullptr;
}

/// Creates a new, empty file in the folder of `path`, with the same extension. Returns an empty string with
/// errno set on failure.
std::string file_beside(const std::string& path) {
  static std::atomic<unsigned> counter{0};
  constexpr int kTries = 100;  // because a killed program may leave files with these names
  for (int k = 0; k < kTries; ++k) {
    const std::string name =
        ".film-" + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".part" + ending_of(path);
    const std::string place = (std::filesystem::path(path).parent_path() / name).string();
    const Descriptor made(::open(place.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (made.get() >= 0) return place;
    if (errno != EEXIST) return {};
  }
  return {};
}

std::vector<std::string> arguments(const std::string& path, const FilmSettings& settings) {
  std::vector<std::string> list = {settings.program,
                                   "-hide_banner",
                                   "-loglevel",
                                   "error",
                                   "-y",
                                   "-f",
                                   "rawvideo",
                                   "-pixel_format",
                                   "rgba",
                                   "-video_size",
                                   std::to_string(settings.width) + "x" + std::to_string(settings.height),
                                   "-framerate",
                                   std::to_string(settings.rate),
                                   "-i",
                                   "pipe:0"};
  const auto add = [&](std::initializer_list<const char*> more) {
    list.insert(list.end(), more.begin(), more.end());
  };
  if (path.ends_with(".mp4"))  // players need even sizes and this pixel format
    add({"-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "-movflags", "+faststart"});
  else if (path.ends_with(".gif"))  // its own palette, and the frame rate that browsers show
    add({"-vf",
         "fps=25,split[a][b];[a]palettegen=stats_mode=full[p];[b][p]paletteuse=dither=bayer:bayer_scale=4"});
  else
    add({"-vf", "fps=30", "-loop", "0", "-quality", "70"});
  // From the name alone, ffmpeg would take x%d.webp for numbered pictures.
  add({"-f", ending_of(path) + 1});
  list.push_back("file:" + path);
  return list;
}

}  // namespace

class Film::Program {
 public:
  static Expected<std::unique_ptr<Program>> start(const std::string& path, const FilmSettings& settings) {
    auto program = std::unique_ptr<Program>(new Program(settings));
    // A socket, not a pipe: if the program has ended, send() returns an error and no signal ends this
    // process.
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
      return fail(ErrorCode::kNoProgram,
                  "Cannot create a socket for " + settings.program + ": " + std::strerror(errno));
    program->ours_ = Descriptor(ends[0]);
    const Descriptor theirs(ends[1]);
    program->said_ = std::tmpfile();
    if (program->said_ == nullptr)
      return fail(ErrorCode::kNoProgram,
                  "Cannot create a file for the output of " + settings.program + ": " + std::strerror(errno));
    Spawn spawn;
    spawn.give(theirs.get(), STDIN_FILENO);
    spawn.open(STDOUT_FILENO, "/dev/null", O_WRONLY);
    spawn.give(::fileno(program->said_), STDERR_FILENO);
    pid_t id = -1;
    const int error = spawn.start(settings.program, arguments(path, settings), nullptr, id);
    if (error != 0)
      return fail(ErrorCode::kNoProgram, settings.program + " cannot be started (" + std::strerror(error) +
                                             "): install it, or record into a folder of PNG files.");
    program->id_ = id;
    // By number, because the header of glibc 2.36 declares pidfd_open for C only.
    program->process_ = Descriptor(static_cast<int>(::syscall(SYS_pidfd_open, id, 0)));
    return program;
  }

  ~Program() {
    if (id_ > 0) {
      ::kill(id_, SIGKILL);
      wait_for_end(id_);
    }
    if (said_ != nullptr) std::fclose(said_);
  }

  Expected<void> write(const void* bytes, std::size_t count) {
    const auto* next = static_cast<const char*>(bytes);
    const Clock::time_point end = Clock::now() + settings_.patience;
    while (count > 0) {
      const ssize_t sent = ::send(ours_.get(), next, count, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent > 0) {
        next += sent;
        count -= static_cast<std::size_t>(sent);
      } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
        if (wait_for(ours_.get(), POLLOUT, end) == 0) return gone("accepts no more pictures");
      } else if (errno != EINTR) {
        return gone("has ended");
      }
    }
    return {};
  }

  Expected<void> finish() {
    ours_.reset();  // ends the program's input
    if (wait_for(process_.get(), POLLIN, Clock::now() + settings_.patience) == 0) return gone("does not end");
    int status = 0;
    ::waitpid(id_, &status, 0);
    id_ = -1;
    // ffmpeg also exits with 0 if the disk was full. Anything it prints at this log level is an error.
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && words().empty()) return {};
    return gone("failed");
  }

 private:
  explicit Program(const FilmSettings& settings) : settings_(settings) {}

  std::string words() {
    std::string text;
    std::rewind(said_);
    for (int c = std::fgetc(said_); c != EOF && text.size() < 400; c = std::fgetc(said_))
      text += static_cast<char>(c);
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return text;
  }

  Expected<void> gone(const std::string& what) {
    const std::string text = words();
    return fail(ErrorCode::kNoProgram, settings_.program + " " + what + (text.empty() ? "." : ": " + text));
  }

  FilmSettings settings_;
  Descriptor ours_, process_;
  std::FILE* said_ = nullptr;
  pid_t id_ = -1;
};

Film::Film(std::string path, FilmSettings settings)
    : path_(std::move(path)), settings_(std::move(settings)) {}
Film::Film(Film&& other) noexcept
    : path_(std::move(other.path_)),
      settings_(std::move(other.settings_)),
      part_(std::exchange(other.part_, {})),
      program_(std::move(other.program_)),
      frames_(other.frames_) {}
Film::~Film() {
  program_.reset();  // before its file is deleted, because it might still write
  if (!part_.empty()) ::unlink(part_.c_str());
}

Expected<Film> Film::create(const std::string& path, FilmSettings settings) {
  Film film(path, std::move(settings));
  std::error_code error;
  if (ending_of(path) != nullptr) {
    if (std::filesystem::is_directory(path, error))
      return fail(ErrorCode::kFileAccess, "Cannot write the film " + path + ": it is a folder.");
    film.part_ = file_beside(path);
    if (film.part_.empty())
      return fail(ErrorCode::kFileAccess,
                  "Cannot write the film " + path + ": " + std::strerror(errno) + ".");
    auto program = Program::start(film.part_, film.settings_);
    if (!program) return tl::unexpected(program.error());
    film.program_ = std::move(*program);
    return film;
  }
  std::filesystem::create_directories(path, error);
  if (!std::filesystem::is_directory(path, error))
    return fail(ErrorCode::kFileAccess, "Cannot create the folder " + path + ".");
  // Refuses a folder with frames. A shorter film would end with the last frames of the older one.
  for (std::filesystem::directory_iterator at(path, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (name.starts_with("frame-") && name.ends_with(".png"))
      return fail(ErrorCode::kFileAccess,
                  "The folder " + path + " contains an earlier film (" + name + "). Choose another folder.");
  }
  if (error)
    return fail(ErrorCode::kFileAccess, "Cannot read the folder " + path + ": " + error.message() + ".");
  return film;
}

Expected<void> Film::add(const render::Picture& picture) {
  if (picture.width != settings_.width || picture.height != settings_.height)
    return fail(ErrorCode::kBadParameter, "A frame does not have the same size as the film.");
  const std::size_t number = frames_++;
  if (program_) return program_->write(picture.pixels.data(), picture.pixels.size() * sizeof(render::Color));
  char name[32];
  std::snprintf(name, sizeof name, "frame-%05zu.png", number);
  return render::write_png(picture, (std::filesystem::path(path_) / name).string());
}

Expected<void> Film::finish() {
  if (!program_) return {};
  if (auto finished = program_->finish(); !finished) return finished;
  std::error_code error;
  const auto bytes = std::filesystem::file_size(part_, error);
  if (error || bytes == 0)
    return fail(ErrorCode::kNoProgram,
                settings_.program + " reported success but wrote no film of " + std::to_string(frames_) +
                    (frames_ == 1 ? " picture. One picture is too short." : " pictures."));
  std::filesystem::rename(part_, path_, error);
  if (error)
    return fail(ErrorCode::kFileAccess, "Cannot write the film " + path_ + ": " + error.message() + ".");
  part_.clear();
  return {};
}

}  // namespace fracture::film
