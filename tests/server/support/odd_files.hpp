// Things that are not plain files, in the place of a file that a server reads.
#pragma once

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace fracture::test {

enum class Odd { kFifo, kLinkToDevice, kLinkToItself, kFolder, kSparse };
inline constexpr Odd kAllOdd[] = {Odd::kFifo, Odd::kLinkToDevice, Odd::kLinkToItself, Odd::kFolder,
                                  Odd::kSparse};

/// Replaces what is at this path. Creates the folder around it.
inline void put_odd(Odd odd, const std::string& path) {
  namespace fs = std::filesystem;
  fs::create_directories(fs::path(path).parent_path());
  fs::remove_all(path);
  switch (odd) {
    case Odd::kFifo:
      ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0) << path;
      break;
    case Odd::kLinkToDevice:
      fs::create_symlink("/dev/zero", path);
      break;
    case Odd::kLinkToItself:
      fs::create_symlink(path, path);
      break;
    case Odd::kFolder:
      fs::create_directory(path);
      break;
    case Odd::kSparse:
      std::ofstream(path) << "x";
      fs::resize_file(path, 2ull << 40);
      break;
  }
}

}  // namespace fracture::test
