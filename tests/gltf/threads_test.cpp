// Any number of threads writes the same file. The data is large enough for several threads.
#include <gtest/gtest.h>

#include "common/gltf/gltf_writer.hpp"
#include "tests/gltf/two_halves.hpp"

namespace fracture::test {
namespace {

/// Both halves 3,000 times, with hulls, tangents and seams. Some normals and tangents have no direction.
FracturedSolid many_halves() {
  FracturedSolid made = two_halves_with_hulls();
  const std::vector<Fragment> halves = made.set.fragments;
  const std::vector<FragmentHulls> hulls = made.hulls.of_fragment;
  made.set.fragments.clear();
  made.hulls.of_fragment.clear();
  for (std::uint32_t k = 0; k < 6000; ++k) {
    Fragment& f = made.set.fragments.emplace_back(halves[k % 2]);
    f.id = k;
    f.sites = {SiteId{k}};
    if (k % 5 == 0) f.attributes.normals.front() = {0, 0, 0};
    if (k % 7 == 0 && !f.attributes.tangents.empty()) f.attributes.tangents.front() = {0, 0, 0, 1};
    made.hulls.of_fragment.push_back(hulls[k % 2]);
  }
  return made;
}

TEST(GltfThreads, DoNotShowInTheFile) {
  const FracturedSolid made = many_halves();
  GltfOptions options;
  options.interior.uvs = {0.5, 0.25, 0.75};
  for (const auto write : {write_glb, write_gltf}) {
    const std::vector<std::uint8_t> one = write(made, options, {});
    EXPECT_GT(one.size(), 8u << 20);
    for (const int threads : {2, 4}) {
      Execution execution;
      execution.threads = threads;
      EXPECT_TRUE(write(made, options, execution) == one) << threads;
    }
  }
}

}  // namespace
}  // namespace fracture::test
