#include "server/bake/output_files.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/base/atomic_file.hpp"
#include "common/digest/running_digest.hpp"
#include "server/bake/output_folders.hpp"
#include "server/bake/standard_output.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;
using outputs::Answer;
using outputs::Sink;

/// The caller reports the error for `output`, so the path is only added if it is another file, such as a
/// texture.
tl::unexpected<Error> not_written(const std::string& path, const std::string& output,
                                  const std::string& reason) {
  return fail(ErrorCode::kFileAccess, path == output ? reason : path + ": " + reason);
}

/// Writes the files of an output one after the other.
class Writing {
 public:
  Writing(const std::string& output, const Objection& objection, const std::stop_token& stop)
      : output_(output), objection_(objection), stop_(stop) {}

  /// `write(sink)` must return false if the sink fails.
  Expected<void> file(const std::string& path, const std::function<bool(const Sink&)>& write) {
    if (const std::optional<Error> why = objection_(path)) return not_written(path, output_, why->detail);
    if (const std::optional<Error> why = refuse_output(path))
      return tl::unexpected<Error>(Error{ErrorCode::kFileAccess, why->detail});
    AtomicFile file;
    RunningDigest digest;
    std::uint64_t bytes = 0;
    const bool good = file.open(path) && write([&](std::string_view block) {
                        if (stop_.stop_requested()) {
                          errno = ECANCELED;
                          return false;
                        }
                        const auto view = std::as_bytes(std::span(block.data(), block.size()));
                        digest.add(view);
                        bytes += block.size();
                        return file.append(view);
                      }) &&
                      file.commit();
    if (!good && errno == ECANCELED) return fail(ErrorCode::kCancelled, "Stopped.");
    if (!good) return not_written(path, output_, std::strerror(errno));
    written_.push_back({path, digest.finish(), bytes});
    return {};
  }

  /// Returns the written files. The output, written last, is moved to the front.
  std::vector<WrittenFile> take() {
    std::rotate(written_.begin(), written_.end() - 1, written_.end());
    return std::move(written_);
  }

 private:
  const std::string& output_;
  const Objection& objection_;
  const std::stop_token stop_;
  std::vector<WrittenFile> written_;
};

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

bool holds(const std::string& path, std::span<const std::uint8_t> bytes) {
  const std::string there = text_of(path);
  return there.size() == bytes.size() && std::memcmp(there.data(), bytes.data(), bytes.size()) == 0;
}

Expected<void> write_textures_and_materials(const std::string& path, const Answer& answer, Writing& writing) {
  const fs::path folder = fs::path(path).parent_path();
  const std::string materials = materials_beside(path), stem = fs::path(path).stem().string();
  if (is_foreign_mtl(materials))
    return not_written(materials, path, "the file exists and was not made by a bake");
  const std::string before = text_of(materials);
  std::vector<std::string> names(answer.images.size());
  for (const std::size_t k : outputs::images_of_mtl(answer)) {
    const auto [ending, bytes] = answer.images[k];
    names[k] = stem + "_texture_" + std::to_string(k) + ending;
    const std::string place = (folder / names[k]).string();
    std::error_code error;
    if (fs::exists(place, error) && before.find(" " + names[k] + "\n") == std::string::npos &&
        !holds(place, bytes))
      return not_written(place, path, "the file exists and was not made by a bake");
    const Expected<void> texture = writing.file(place, [&, bytes = bytes](const Sink& sink) {
      return sink({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    });
    if (!texture) return texture;
  }
  return writing.file(materials, [&](const Sink& sink) { return write_mtl(answer, names, sink); });
}

}  // namespace

Expected<std::vector<WrittenFile>> write_output(const std::string& path, OutputKind kind,
                                                std::span<const std::uint8_t> answer,
                                                outputs::VertexColors colors, const Objection& objection,
                                                const std::stop_token& stop) {
  const Expected<Answer> read = outputs::read_answer(answer);
  if (!read) return tl::unexpected<Error>(read.error());
  Writing writing(path, objection, stop);
  if (kind == OutputKind::kObj)
    if (const auto beside = write_textures_and_materials(path, *read, writing); !beside)
      return tl::unexpected<Error>(beside.error());
  const auto written = writing.file(path, [&](const Sink& sink) {
    if (kind == OutputKind::kPly) return write_ply(*read, colors, sink);
    if (kind == OutputKind::kStl) return write_stl(*read, sink);
    return write_obj(*read, fs::path(materials_beside(path)).filename().string(), colors, sink);
  });
  if (!written) return tl::unexpected<Error>(written.error());
  return writing.take();
}

Expected<std::vector<WrittenFile>> write_answer(const std::string& path, OutputKind kind,
                                                const std::vector<std::uint8_t>& answer, const Digest& digest,
                                                MeshFormat source, const Objection& objection,
                                                const std::stop_token& stop) {
  if (kind == OutputKind::kGlb || kind == OutputKind::kGltf) {
    const auto bytes = std::as_bytes(std::span(answer));
    const bool good = path == kStandardStream ? write_standard_output(bytes, stop)
                                              : make_folders_of(path) && write_atomically(path, bytes);
    if (good) return std::vector<WrittenFile>{{path, digest, bytes.size()}};
  } else if (make_folders_of(path)) {
    const bool linear = source == MeshFormat::kGlb || source == MeshFormat::kGltf;
    return write_output(path, kind, answer,
                        linear ? outputs::VertexColors::kToSrgb : outputs::VertexColors::kKeep, objection,
                        stop);
  }
  return fail(errno == ECANCELED ? ErrorCode::kCancelled : ErrorCode::kFileAccess, std::strerror(errno));
}

bool is_foreign_mtl(const std::string& path) {
  std::error_code error;
  if (path.empty() || !fs::exists(path, error)) return false;
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return !line.starts_with(std::string("# ") + outputs::kGenerator);
}

std::optional<std::string> digest_of_file(const std::string& path) {
  // The path comes from a report, which anyone may have edited. Skip devices, because reading one might never
  // end.
  std::error_code gone;
  if (!std::filesystem::is_regular_file(path, gone)) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  RunningDigest digest;
  std::vector<char> block(std::size_t{1} << 20);
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())) || file.gcount() > 0)
    digest.add(std::as_bytes(std::span(block.data(), static_cast<std::size_t>(file.gcount()))));
  if (file.bad()) return std::nullopt;
  return "sha256:" + digest.finish().hex();
}

}  // namespace fracture::bake
