// fuzz_fracture as a test: every file of its corpus, which includes inputs that once found something, and
// some random inputs. An input that fails ends the program and prints how to repeat it.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "common/base/random.hpp"
#include "tests/fuzz/fracture_case.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace fracture::fuzz {

std::string& last_outcome();

namespace {

TEST(FuzzFracture, EveryInputOfTheCorpusIsSoundOrRefused) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(FRACTURE_FUZZ_CORPUS))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  ASSERT_GE(files.size(), 3u) << FRACTURE_FUZZ_CORPUS;
  std::size_t sound = 0;
  for (const auto& path : files) {
    std::ifstream file(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    std::printf("%s\n", path.filename().c_str());
    std::fflush(stdout);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    sound += last_outcome() == "sound";
  }
  EXPECT_GT(sound, files.size() / 2) << "most are fractured, not refused";
}

TEST(FuzzFracture, BytesAlwaysMakeACaseThatTheTableAccepts) {
  Random random(20261122);
  std::size_t refused_parameters = 0;
  for (int k = 0; k < 500; ++k) {
    std::vector<std::uint8_t> bytes(random.below(500));
    for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random());
    const FractureCase one = decode_case(bytes.data(), bytes.size()),
                       two = decode_case(bytes.data(), bytes.size());
    EXPECT_FALSE(one.shape.empty());
    EXPECT_EQ(one.mesh.positions, two.mesh.positions);
    EXPECT_EQ(one.request, two.request);
    refused_parameters += one.request.empty();
  }
  EXPECT_LT(refused_parameters, 50u) << "the table refuses whole requests";
}

}  // namespace
}  // namespace fracture::fuzz
