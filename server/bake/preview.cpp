#include "server/bake/preview.hpp"

#include <stdlib.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "common/base/atomic_file.hpp"
#include "server/bake/output_folders.hpp"
#include "server/bake/output_path.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A renderer that fails this many times in a row is not used again, so that a large bake does not wait for
/// every timeout.
constexpr int kMostFailuresInARow = 3;
/// Number of pictures after which a renderer process is replaced, to free memory that its driver has leaked.
/// Starting a process costs as much as two small pictures.
constexpr std::size_t kPicturesPerProcess = 200;
/// The size of 4096 x 4096 pixels without compression, which is more than any of our pictures needs.
constexpr std::uintmax_t kMaxPictureBytes = 64u << 20;
/// How far fragments are moved apart: cuts become visible, and the whole can still be recognized.
constexpr double kExplode = 0.35;
/// Side in pixels up to which a fine picture is supersampled at twice its size. This quadruples the pixels,
/// which are most of the work.
constexpr int kMostSupersampled = 1024;
/// Number of sky directions that cast shadows: half as many as in the gallery, for two thirds of its time.
constexpr int kFineShadows = 16;

constexpr unsigned char kPngHead[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n',
                                      0,    0,   0,   13,  'I',  'H',  'D',  'R'};
constexpr unsigned char kPngEnd[] = {'I', 'E', 'N', 'D', 0xae, 'B', '`', 0x82};

std::uint32_t big_endian(const char* at) {
  std::uint32_t value = 0;
  for (int k = 0; k < 4; ++k) value = value << 8 | static_cast<unsigned char>(at[k]);
  return value;
}

/// Returns whether the bytes begin like a PNG of that size.
bool has_size(std::string_view png, int size) {
  if (png.size() < 24 || std::memcmp(png.data(), kPngHead, sizeof kPngHead) != 0) return false;
  const auto side = static_cast<std::uint32_t>(size);
  return big_endian(png.data() + 16) == side && big_endian(png.data() + 20) == side;
}

bool is_newer(const struct stat& a, const struct stat& b) {
  return a.st_mtim.tv_sec != b.st_mtim.tv_sec ? a.st_mtim.tv_sec > b.st_mtim.tv_sec
                                              : a.st_mtim.tv_nsec >= b.st_mtim.tv_nsec;
}

/// Returns whether the picture is newer than the output and has the right size.
bool is_current(const std::string& picture, const std::string& output, int size) {
  struct stat of_picture {
  }, of_output{};
  if (::stat(picture.c_str(), &of_picture) != 0 || ::stat(output.c_str(), &of_output) != 0) return false;
  if (!is_newer(of_picture, of_output)) return false;
  std::ifstream file(picture, std::ios::binary);
  char head[24] = {};
  return file.read(head, sizeof head) && has_size({head, sizeof head}, size);
}

/// Removes a file when destroyed.
struct Scratch {
  std::string path;
  ~Scratch() {
    std::error_code error;
    fs::remove(path, error);
  }
};

void replace_all(std::string& text, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
    text.replace(at, what.size(), by);
}

}  // namespace

Previews::Previews(PreviewSettings settings, std::function<void(const std::string& line)> say)
    : settings_(std::move(settings)), say_(std::move(say)) {
  if (settings_.renderer.empty()) return;
  std::error_code error;
  std::string name = (fs::temp_directory_path(error) / "fracture-preview-XXXXXX").string();
  if (!error && ::mkdtemp(name.data())) folder_ = name;
}

Previews::~Previews() {
  idle_.clear();
  std::error_code error;
  if (!folder_.empty()) fs::remove_all(folder_, error);
}

std::size_t Previews::drawn() const {
  const std::lock_guard lock(mutex_);
  return drawn_;
}

std::size_t Previews::failed() const {
  const std::lock_guard lock(mutex_);
  return failed_;
}

json Previews::of(const std::string& output, const std::string& picture, bool fresh,
                  std::span<const std::byte> bytes, const std::stop_token& stop) {
  if (!fresh && is_current(picture, output, settings_.size)) return {{"file", picture}};
  if (settings_.renderer.empty()) return nullptr;
  const Expected<void> done = [&]() -> Expected<void> {
    try {
      return draw(output, picture, bytes, stop);
    } catch (const std::exception& bug) {  // the output exists even if its picture fails
      return fail(ErrorCode::kInternal, bug.what());
    }
  }();
  if (done) {
    note(true, false);
    return {{"file", picture}};
  }
  if (done.error().code == ErrorCode::kCancelled) return nullptr;
  note(false, done.error().code == ErrorCode::kNoProgram);
  return {{"file", picture}, {"warning", done.error().detail}};
}

void Previews::note(bool good, bool renderer_failed) {
  bool given_up = false;
  {
    const std::lock_guard lock(mutex_);
    ++(good ? drawn_ : failed_);
    if (failures_in_a_row_ >= kMostFailuresInARow) return;
    failures_in_a_row_ = renderer_failed ? failures_in_a_row_ + 1 : 0;
    given_up = failures_in_a_row_ == kMostFailuresInARow;
  }
  if (given_up)
    say_("warning: the renderer failed " + std::to_string(kMostFailuresInARow) +
         " times in a row; no more pictures will be drawn");
}

Expected<void> Previews::draw(const std::string& output, const std::string& picture,
                              std::span<const std::byte> bytes, const std::stop_token& stop) {
  const Expected<OutputKind> kind = kind_of_output(output);
  const bool is_drawn_itself =
      output != kStandardStream && kind && (*kind == OutputKind::kGlb || *kind == OutputKind::kGltf);
  if (!is_drawn_itself && bytes.empty())
    return fail(
        ErrorCode::kUnsupportedFeature,
        "bake draws the picture of an OBJ, PLY or STL file only when it writes the file. To write the "
        "file again, use --force.");
  if (folder_.empty())
    return fail(ErrorCode::kNoProgram,
                "Pictures need a folder for temporary files, but none could be created. "
                "Set TMPDIR to a folder that bake can write to.");
  std::size_t number = 0;
  {
    const std::lock_guard lock(mutex_);
    if (failures_in_a_row_ >= kMostFailuresInARow)
      return fail(ErrorCode::kNoProgram, "The renderer failed " + std::to_string(kMostFailuresInARow) +
                                             " times in a row, so bake did not try to draw this picture.");
    number = next_++;
  }
  // The renderer is given file names that we choose, because a user's file names can contain anything.
  const Scratch model{folder_ + "/" + std::to_string(number) + ".glb"},
      drawn{folder_ + "/" + std::to_string(number) + ".png"};
  if (!is_drawn_itself) {
    if (!write_atomically(model.path, bytes))
      return fail(ErrorCode::kFileAccess, "Cannot write " + model.path + ": " + std::strerror(errno) + ".");
  } else {
    std::error_code error;
    fs::create_symlink(fs::absolute(output, error), model.path, error);
    if (error)
      return fail(ErrorCode::kFileAccess, "Cannot write " + model.path + ": " + error.message() + ".");
  }
  const std::string side = std::to_string(settings_.size);
  const json line = {{"file", model.path},
                     {"output", drawn.path},
                     {"size", side + "x" + side},
                     {"view", "exploded"},
                     {"explode", kExplode},
                     {"supersample", settings_.fine && settings_.size <= kMostSupersampled ? 2 : 1},
                     {"sky-shadows", settings_.fine ? kFineShadows : 0}};
  if (Expected<void> done = draw_by_one(line, stop); !done) {
    replace_all(done.error().detail, model.path, output == kStandardStream ? "the output" : output);
    replace_all(done.error().detail, drawn.path, picture);
    return done;
  }
  std::error_code error;
  std::string png;
  if (const std::uintmax_t size = fs::file_size(drawn.path, error); !error && size <= kMaxPictureBytes) {
    std::ifstream file(drawn.path, std::ios::binary);
    png.assign(std::istreambuf_iterator<char>(file), {});
  }
  if (!has_size(png, settings_.size) || png.size() < 24 + sizeof kPngEnd ||
      std::memcmp(png.data() + png.size() - sizeof kPngEnd, kPngEnd, sizeof kPngEnd) != 0)
    return fail(ErrorCode::kBadImage,
                "The renderer did not write a PNG of " + side + " x " + side + " pixels.");
  if (!make_folders_of(picture) || !write_atomically(picture, std::as_bytes(std::span(png))))
    return fail(ErrorCode::kFileAccess, "Cannot write " + picture + ": " + std::strerror(errno) + ".");
  return {};
}

Expected<void> Previews::draw_by_one(const json& line, const std::stop_token& stop) {
  Idle mine;
  {
    std::unique_lock lock(mutex_);
    if (!freed_.wait(lock, stop, [&] { return busy_ < settings_.at_once; }))
      return fail(ErrorCode::kCancelled, "Stopped.");
    ++busy_;
    if (!idle_.empty()) {
      mine = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  const std::shared_ptr<void> turn(nullptr, [this](void*) {
    {
      const std::lock_guard lock(mutex_);
      --busy_;
    }
    freed_.notify_one();
  });
  Expected<void> done;
  if (!mine.process) {
    Expected<RendererProcess> started = RendererProcess::start(settings_.renderer, settings_.threads);
    if (started)
      mine.process = std::make_unique<RendererProcess>(std::move(*started));
    else
      done = tl::unexpected(started.error());
  }
  if (mine.process) done = mine.process->draw(line, settings_.limit, stop);
  ++mine.pictures;
  if (mine.process && (!mine.process->alive() || mine.pictures >= kPicturesPerProcess)) mine.process.reset();
  if (mine.process) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(mine));
  }
  return done;
}

}  // namespace fracture::bake
