// Reads the files that a FailureKeeper has left in its folder.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/server/support/child_process.hpp"

namespace fracture::test {

struct Kept {
  std::filesystem::path place;
  nlohmann::json request;  ///< request.json
};

inline std::vector<Kept> kept_in(const std::string& folder) {
  std::vector<Kept> kept;
  if (!std::filesystem::exists(folder)) return kept;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    EXPECT_FALSE(entry.path().filename().string().ends_with(".part")) << entry.path();
    kept.push_back({entry.path(), nlohmann::json::parse(read_file(entry.path() / "request.json"))});
  }
  return kept;
}

}  // namespace fracture::test
