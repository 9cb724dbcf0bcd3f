// Meshes that who runs the server lays beside the shapes that the page makes by itself (--page-sample): to be broken without a file
// of one's own. Whoever gets the page gets them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"

namespace fracture::page {

inline constexpr std::size_t kMostSamples = 16;
inline constexpr std::uint64_t kMostSampleBytes =
    16u << 20;  ///< of all together, which are held while the server runs

/// What the list of them is called below /page/.
inline constexpr std::string_view kSampleList = "samples.json";

class Samples {
 public:
  Samples() = default;
  /// kFileAccess: one cannot be read, is empty or no regular file; kTooLarge: they are too many or too large.
  static Expected<Samples> load(const std::vector<std::string>& paths);

  /// JSON: [{"name": "Suzanne_248.blend", "file": "sample-0", "bytes": 279448}]; `file` as below /page/.
  const std::string& list() const { return list_; }
  /// The bytes; null where there is none.
  const std::string* find(std::string_view file) const;

 private:
  std::vector<std::string> files_;
  std::string list_ = "[]\n";
};

}  // namespace fracture::page
