#include "server/bake/mesh_search.hpp"

#include <glob.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <system_error>
#include <utility>

#include "common/import/import_input.hpp"
#include "server/bake/result_file.hpp"
#include "server/bake/wrong.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;

bool is_mesh_name(const fs::path& path) {
  const std::string ending = path.extension().string();
  return ending.size() > 1 && format_from_extension(ending.substr(1)).has_value();
}

bool is_report_name(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.starts_with("bake.") && name.ends_with(".ndjson");
}

bool is_glob(const std::string& text) { return text.find_first_of("*?[") != std::string::npos; }

}  // namespace

bool stands_for_many(const std::string& input) {
  std::error_code error;
  return fs::is_directory(input, error) || (is_glob(input) && !fs::exists(input, error));
}

void MeshSearch::add_report(const std::string& report) { add_results_of_report(report, results_); }

Expected<void> MeshSearch::look_into(const std::string& input) {
  std::error_code error;
  const std::size_t before = found_.size(), skipped_before = skipped_.size(),
                    dangling_before = dangling_.size();
  Expected<void> looked;
  if (fs::is_directory(input, error))
    looked = look_into_folder(input);
  else if (is_glob(input) && !fs::exists(input, error))
    look_into_glob(input);
  else
    found_.push_back({input, fs::path(input).filename()});
  if (!looked || found_.size() > before) return looked;
  const std::size_t results = skipped_.size() - skipped_before;
  if (dangling_.size() > dangling_before)
    return wrong("No mesh was found in '" + input + "'. The target of the link '" +
                 dangling_[dangling_before] + "' does not exist.");
  return wrong("No mesh was found in '" + input + "'" +
               (results > 1    ? ", only " + std::to_string(results) + " results of earlier bakes."
                : results == 1 ? ", only one result of an earlier bake."
                               : "."));
}

std::vector<FoundMesh> MeshSearch::found() const {
  std::vector<FoundMesh> sorted = found_;
  std::sort(sorted.begin(), sorted.end(),
            [](const FoundMesh& a, const FoundMesh& b) { return a.path < b.path; });
  return sorted;
}

Expected<void> MeshSearch::look_into_folder(const std::string& folder) {
  std::error_code error;
  const std::size_t dangling_before = dangling_.size();
  root_ = folder;
  searched_.clear();
  meshes_.clear();
  // A link to a folder around the input would lead to files that were not given.
  for (fs::path around = fs::canonical(folder, error); !error && around.has_relative_path();) {
    around = around.parent_path();
    searched_.insert(identity_of(around.string()));
  }
  folders_ = {folder};
  links_.clear();
  while (!folders_.empty() || !links_.empty()) {
    if (folders_.empty()) {
      const auto next = std::min_element(links_.begin(), links_.end());
      folders_.push_back(std::move(*next));
      links_.erase(next);
    }
    const std::string next = std::move(folders_.back());
    folders_.pop_back();
    if (const FileIdentity identity = identity_of(next);
        left_out_.contains(identity) || !searched_.insert(identity).second)
      continue;
    if (const auto looked = look_into_one(next); !looked) return looked;
  }
  std::sort(dangling_.begin() + static_cast<std::ptrdiff_t>(dangling_before), dangling_.end());
  // Reports anywhere in the folder say which of its meshes are results.
  for (FoundMesh& mesh : std::exchange(meshes_, {})) add(std::move(mesh));
  return {};
}

Expected<void> MeshSearch::look_into_one(const std::string& folder) {
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const fs::path& path = at->path();
    std::error_code missing;
    const fs::file_status target = at->status(missing);
    if (fs::is_directory(target)) {
      (at->is_symlink(missing) ? links_ : folders_).push_back(path.string());
    } else if (fs::is_regular_file(target)) {
      if (is_mesh_name(path))
        meshes_.push_back({path.string(), path.lexically_relative(root_)});
      else if (is_report_name(path))
        add_report(path.string());
    } else if (at->is_symlink(missing) && !fs::exists(target)) {
      if (is_mesh_name(path))
        meshes_.push_back({path.string(), path.lexically_relative(root_)});
      else
        dangling_.push_back(path.string());
    }
  }
  if (error) return wrong("The folder '" + folder + "' cannot be read: " + error.message() + ".");
  return {};
}

void MeshSearch::look_into_glob(const std::string& pattern) {
  glob_t matches{};
  const int result = ::glob(pattern.c_str(), 0, nullptr, &matches);
  for (std::size_t k = 0; result == 0 && k < matches.gl_pathc; ++k) {
    const fs::path path = matches.gl_pathv[k];
    std::error_code error;
    if (!is_mesh_name(path)) continue;
    if (fs::is_regular_file(path, error) || (fs::is_symlink(path, error) && !fs::exists(path, error)))
      add({path.string(), path.filename()});
  }
  ::globfree(&matches);
}

void MeshSearch::add(FoundMesh mesh) {
  const std::optional<MeshFormat> format =
      format_from_extension(fs::path(mesh.path).extension().string().substr(1));
  const bool result = (!results_.empty() && results_.contains(identity_of(mesh.path))) ||
                      (format && is_result_file(mesh.path, *format));
  if (result)
    skipped_.push_back(mesh.path);
  else
    found_.push_back(std::move(mesh));
}

}  // namespace fracture::bake
