// A folder that one server at a time may use: <folder>/lock is held by its open descriptor (flock(2)), so that the lock
// of a process that died is none.
#pragma once

#include <string>

#include "common/base/descriptor.hpp"
#include "common/base/error.hpp"

namespace fracture {

class FolderLock {
 public:
  /// Makes the folder. False while another server holds it: to be called again. kFileAccess for a folder that cannot be
  /// made or written.
  Expected<bool> take(const std::string& folder);

 private:
  Descriptor file_;
};

}  // namespace fracture
