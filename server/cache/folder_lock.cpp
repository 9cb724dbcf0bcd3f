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
    return tl::unexpected<Error>(unusable_folder(folder, e));
  }
  Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (!file) return tl::unexpected<Error>(unusable_folder(folder, std::strerror(errno)));
  if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) return false;
    return tl::unexpected<Error>(unusable_folder(folder, std::strerror(errno)));
  }
  file_ = std::move(file);
  return true;
}

}  // namespace fracture
