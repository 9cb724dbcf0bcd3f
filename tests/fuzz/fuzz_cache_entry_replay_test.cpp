// The fuzz target as a test: valid entries and seeded mutations of them, replayed in every build.
#include <gtest/gtest.h>

#include <vector>

#include "common/base/random.hpp"
#include "server/cache/entry.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace fracture {
namespace {

TEST(FuzzCacheEntry, ValidEntriesAndTheirMutationsAreDecodedOrRefused) {
  Random random(2026);
  for (int i = 0; i < 20'000; ++i) {
    const std::vector<std::uint8_t> payload(random.below(300), 'p');
    const std::string head = encode_entry_head({"0123456789abcdef", "glb\nsha256:00", payload});
    std::vector<std::uint8_t> bytes(head.begin(), head.end());
    bytes.insert(bytes.end(), payload.begin(), payload.end());
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
    for (std::uint64_t changes = 1 + random.below(3); changes > 0; --changes)
      bytes[random.below(std::min<std::size_t>(bytes.size(), 80))] =
          static_cast<std::uint8_t>(random.below(256));
    if (random.below(4) == 0) bytes.resize(random.below(bytes.size() + 1));
    // A copy of exactly this size, so that the sanitizer detects the first read beyond it.
    const std::vector<std::uint8_t> exact(bytes.begin(), bytes.end());
    LLVMFuzzerTestOneInput(exact.data(), exact.size());
  }
  SUCCEED() << "the target aborts on a finding";
}

}  // namespace
}  // namespace fracture
