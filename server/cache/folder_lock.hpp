// A lock on a folder that only one server at a time may use. The lock on <folder>/lock belongs to an open descriptor
// (flock(2)), so it ends when its process dies.
#pragma once

#include <filesystem>
#include <string>

#include "common/base/descriptor.hpp"
#include "common/base/error.hpp"

namespace fracture {

/// The error for a folder that the server cannot use. `path`: the folder, or the part of it that failed.
inline Error unusable_folder(const std::string& path, const std::string& reason) {
  return {ErrorCode::kFileAccess, "the folder '" + path + "' cannot be created or written to: " + reason +
                                      ". Choose a folder that the server can write to."};
}
/// The same for an exception, without its words for programmers.
inline Error unusable_folder(const std::string& folder, const std::filesystem::filesystem_error& error) {
  return unusable_folder(error.path1().empty() ? folder : error.path1().string(), error.code().message());
}

class FolderLock {
 public:
  /// Creates the folder and locks it. Returns false while another server holds the lock; the caller should try again later.
  /// Errors: kFileAccess if the folder cannot be created or written.
  Expected<bool> take(const std::string& folder);

 private:
  Descriptor file_;
};

}  // namespace fracture
