// Whether files can be written where outputs are to lie, found by trying before anything is computed.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace fracture::bake {

/// Thread-safe.
class OutputFolders {
 public:
  /// Makes the folder of the path, and in it a file that is gone again; each folder is tried once. The reason if that
  /// fails: "the folder 'out' cannot be written to: Permission denied".
  std::optional<std::string> fault_of(const std::string& path);

 private:
  std::mutex mutex_;
  std::map<std::string, std::optional<std::string>> faults_;  ///< by folder
};

}  // namespace fracture::bake
