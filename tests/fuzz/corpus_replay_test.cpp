// A fuzz target as a test: every file of its corpus, whole, cut short, and with seeded changes.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "common/base/random.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace fracture::test {
namespace {

void run(const std::string& input) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

TEST(FuzzCorpus, KeepsThePromisesWholeCutAndChanged) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(FRACTURE_FUZZ_CORPUS))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  ASSERT_GE(files.size(), 3u) << FRACTURE_FUZZ_CORPUS;
  constexpr std::uint64_t kSeed = 20260101;
  Random random(kSeed);
  for (const auto& path : files) {
    std::ifstream file(path, std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(file), {}};
    SCOPED_TRACE(path.string());
    run(whole);
    for (int round = 0; round < 300 && !whole.empty(); ++round) {
      run(whole.substr(0, random.below(whole.size())));
      std::string mutant = whole;
      for (std::uint64_t k = 0, n = 1 + random.below(4); k < n; ++k)
        mutant[random.below(mutant.size())] = static_cast<char>(random.below(256));
      run(mutant);
    }
  }
}

}  // namespace
}  // namespace fracture::test
