#include "server/bake/picture_paths.hpp"

#include <filesystem>
#include <system_error>

#include "common/base/json_text.hpp"
#include "server/bake/output_path.hpp"
#include "server/bake/report.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEnding = ".png";

tl::unexpected<Error> not_possible(std::string detail) {
  return fail(ErrorCode::kBadParameter, std::move(detail));
}

/// Returns a relative path under `folder` for any output, even for one outside that folder.
std::string below(const fs::path& folder, const std::string& output) {
  if (output == kStandardStream) return "standard-output";
  std::error_code error;
  const fs::path from = fs::absolute(folder.empty() ? "." : folder, error).lexically_normal(),
                 path = fs::absolute(output, error).lexically_normal().lexically_relative(from);
  fs::path name;
  for (const fs::path& part : path) name /= part == ".." ? "up" : part;
  return as_utf8(name.string());
}

}  // namespace

std::string part_of(const Shard& shard) {
  if (shard.count <= 1) return {};
  return "." + std::to_string(shard.index) + "-of-" + std::to_string(shard.count);
}

std::string page_of(const BakeSource& source) {
  if (source.html.empty()) return {};
  fs::path page = source.html;
  const std::string ending = page.extension().string();
  page.replace_extension(part_of(source.shard) + ending);
  return page.string();
}

Expected<void> give_pictures(const BakeSource& source, bool single, std::vector<BakeJob>& jobs) {
  if (source.preview.empty() && source.html.empty()) return {};
  if (source.preview == kStandardStream || source.html == kStandardStream)
    return not_possible(
        "--preview and --html cannot be '-', because standard output is for the fragments: give the name of a file or folder.");
  std::error_code error;
  const bool png = fs::path(source.preview).extension() == kEnding;
  if (single && !source.preview.empty()) {
    if (!png)
      return not_possible("For one mesh, --preview is a PNG file: '" + source.preview +
                          "' must end in .png.");
    jobs.front().picture = source.preview;
    return {};
  }
  fs::path folder = source.preview;
  if (source.preview.empty()) {
    folder = source.html;
    folder.replace_extension(".pictures");
  } else if (png || (fs::exists(folder, error) && !fs::is_directory(folder, error))) {
    return not_possible("For several meshes, or a folder of meshes, --preview must be a folder, but '" +
                        source.preview + "' is a file.");
  }
  const fs::path outputs = single || !source.manifest.empty()
                               ? fs::path(single ? source.output : source.manifest).parent_path()
                               : fs::path(source.output);
  for (BakeJob& job : jobs) job.picture = (folder / below(outputs, job.output)).string() + kEnding;
  return {};
}

}  // namespace fracture::bake
