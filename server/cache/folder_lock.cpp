#include "server/cache/folder_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

namespace fracture {

Expected<bool> FolderLock::take(const std::string& folder) {
  if (file_) return true;
  const std::string path = folder + "/lock";
  try {
    std::filesystem::create_directories(folder);
  } catch (const std::filesystem::filesystem_error& e) {
    return fail(ErrorCode::kFileAccess, e.what());
  }
  Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (!file) return fail(ErrorCode::kFileAccess, path + ": " + std::strerror(errno));
  if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) return false;
    return fail(ErrorCode::kFileAccess, path + ": " + std::strerror(errno));
  }
  file_ = std::move(file);
  return true;
}

}  // namespace fracture
