// Output folders: creates them, and tests whether they are writable before anything is computed.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace fracture::bake {

/// Creates the parent folders of a path. Returns false and sets errno on failure.
bool make_folders_of(const std::string& path);

/// Thread-safe.
class OutputFolders {
 public:
  /// Creates the folder of `path` and tests it by creating and deleting a file. Each folder is tested only
  /// once. Returns the reason on failure: "the folder 'out' cannot be written to: Permission denied".
  std::optional<std::string> fault_of(const std::string& path);

 private:
  std::mutex mutex_;
  std::map<std::string, std::optional<std::string>> faults_;  ///< by folder
};

}  // namespace fracture::bake
