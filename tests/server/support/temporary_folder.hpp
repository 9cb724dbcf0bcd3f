// A test's own folder, deleted at the end of the test.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace fracture::test {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "fracture-test-XXXXXX").string();
    if (!::mkdtemp(name.data())) throw std::runtime_error("mkdtemp");
    path = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string operator/(const std::string& name) const { return path + "/" + name; }
  /// Writes `text` to a new file. Returns its path.
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(*this / name, std::ios::binary) << text;
    return *this / name;
  }

  std::string path;
};

/// The files below the folder of a DiskCache whose names are keys.
inline std::vector<std::filesystem::path> entries_in(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& sub : std::filesystem::directory_iterator(folder))
    if (sub.is_directory() && sub.path().filename().string().size() == 2)
      for (const auto& file : std::filesystem::directory_iterator(sub)) files.push_back(file.path());
  return files;
}

}  // namespace fracture::test
