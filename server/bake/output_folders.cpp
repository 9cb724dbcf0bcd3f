#include "server/bake/output_folders.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "common/base/atomic_file.hpp"
#include "server/bake/output_path.hpp"

namespace fracture::bake {

bool make_folders_of(const std::string& path) {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (folder.empty()) return true;
  std::filesystem::create_directories(folder, error);
  if (error) errno = error.value();
  return !error;
}

std::optional<std::string> OutputFolders::fault_of(const std::string& path) {
  if (path.empty() || path == kStandardStream) return std::nullopt;
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const std::lock_guard lock(mutex_);
  const auto [at, fresh] = faults_.try_emplace(folder);
  if (!fresh) return at->second;
  AtomicFile file;
  if (!make_folders_of(path) || !file.open(path))
    at->second =
        "the folder '" + (folder.empty() ? "." : folder) + "' cannot be written to: " + std::strerror(errno);
  return at->second;
}

}  // namespace fracture::bake
