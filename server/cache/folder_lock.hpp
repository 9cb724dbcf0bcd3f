// A lock on a folder that only one server at a time may use. The lock on <folder>/lock belongs to an open descriptor
// (flock(2)), so it ends when its process dies.
#pragma once

#include <string>

#include "common/base/descriptor.hpp"
#include "common/base/error.hpp"

namespace fracture {

class FolderLock {
 public:
  /// Creates the folder and locks it. Returns false while another server holds the lock; the caller should try again later.
  /// Errors: kFileAccess if the folder cannot be created or written.
  Expected<bool> take(const std::string& folder);

 private:
  Descriptor file_;
};

}  // namespace fracture
