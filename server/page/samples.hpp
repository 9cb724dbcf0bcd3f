// Meshes that the operator adds to the page's own shapes (--page-sample), so that visitors can break them
// without a file of their own. Everyone who can open the page can download them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"

namespace fracture::page {

inline constexpr std::size_t kMostSamples = 16;
inline constexpr std::uint64_t kMostSampleBytes =
    16u << 20;  ///< for all together; they stay in memory while the server runs

/// Name of their list, below /page/.
inline constexpr std::string_view kSampleList = "samples.json";

class Samples {
 public:
  Samples() = default;
  /// Returns kFileAccess if a file cannot be read, is empty or is not a regular file, and kTooLarge if there
  /// are too many or they are too large.
  static Expected<Samples> load(const std::vector<std::string>& paths);

  /// Returns JSON: [{"name": "Suzanne_248.blend", "file": "sample-0", "bytes": 279448}]. `file` is relative
  /// to /page/.
  const std::string& list() const { return list_; }
  /// Returns the bytes of a sample, or null.
  const std::string* find(std::string_view file) const;

 private:
  std::vector<std::string> files_;
  std::string list_ = "[]\n";
};

}  // namespace fracture::page
