// A disk cache in a test's own folder, and entries for it.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "common/digest/digest.hpp"
#include "server/cache/disk_cache.hpp"
#include "tests/server/support/temporary_folder.hpp"

namespace fracture::test {

inline std::string key_of(int n) { return sha256("key " + std::to_string(n)).hex(); }
/// The payload follows from the key, so a wrong byte is detected without storing what was written.
inline std::vector<std::uint8_t> payload_of(int n, std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  std::uint32_t state = static_cast<std::uint32_t>(n) * 2654435761u + 1;
  for (auto& b : bytes) b = static_cast<std::uint8_t>((state = state * 1664525u + 1013904223u) >> 24);
  return bytes;
}

struct Disk : testing::Test {
  TemporaryFolder folder;
  std::string path = folder.path + "/cache";

  static bool insert(DiskCache& cache, int n, std::size_t size = 1000) {
    const std::vector<std::uint8_t> payload = payload_of(n, size);
    const std::string key = key_of(n);
    return cache.insert({key, std::to_string(size), payload});
  }
  /// Returns whether the entry is found. A wrong byte fails the test.
  static bool finds(DiskCache& cache, int n) {
    const auto stored = cache.find(key_of(n));
    if (!stored) return false;
    const std::vector<std::uint8_t> expected = payload_of(n, std::stoul(std::string(stored->entry.metadata)));
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), stored->entry.payload.begin(),
                           stored->entry.payload.end()))
        << "wrong bytes of " << n;
    return true;
  }
};

}  // namespace fracture::test
