// The fuzz target as a test: small valid files and seeded mutations of them, replayed in every build.
#include <gtest/gtest.h>

#include "common/base/random.hpp"
#include "tests/import/make_files.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace fracture::test {
namespace {

std::vector<std::string> corpus() {
  Tetrahedron tet;
  Tetrahedron sparse;
  std::string index, value;
  put<std::uint16_t>(index, {3});
  put<float>(value, {0, 0, 4});
  const std::size_t i = sparse.add_accessor(index, 5123, 1, "SCALAR"),
                    v = sparse.add_accessor(value, 5126, 1, "VEC3");
  sparse.json["accessors"][0]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", sparse.json["accessors"][i]["bufferView"]}, {"componentType", 5123}}},
      {"values", {{"bufferView", sparse.json["accessors"][v]["bufferView"]}}}};
  Tetrahedron embedded;
  embedded.json["buffers"][0]["uri"] =
      "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/"
      "AAACAAEAAAABAAMAAAADAAIAAQACAAMA";
  std::vector<std::string> files;
  const auto add = [&files](char format, const std::string& file) {
    files.emplace_back(1, format).append(file);
  };
  add(0, tet.glb());
  add(0, sparse.glb());
  add(1, embedded.json.dump());
  add(2, std::string(84, 'x'));
  add(2, "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n");
  add(3,
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nelement face 1\nproperty list uchar int i\n"
      "end_header\n1\n2\n3\n3 0 1 2\n");
  add(4, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  return files;
}

/// Makes one random change. Half of the changes replace a digit with a number that strains arithmetic.
void mutate(std::string& file, Random& random) {
  static const std::string kNumbers[] = {
      "-1", "4294967295", "4294967296", "9223372036854775808", "18446744073709551615", "1e308", "0", "7"};
  const std::uint64_t kind = random.below(8), at = 1 + random.below(file.size() - 1);
  if (kind == 0) {
    file[at] = static_cast<char>(random.below(256));
  } else if (kind == 1) {
    file[at] = static_cast<char>(file[at] ^ (1 << random.below(8)));
  } else if (kind == 2) {
    file.erase(at, 1 + random.below(8));
  } else if (kind == 3) {
    file.insert(at, 1 + random.below(8), "0192-[{\"\xff"[random.below(9)]);
  } else {
    const std::size_t digit = file.find_first_of("0123456789", at);
    if (digit != std::string::npos) file.replace(digit, 1, kNumbers[random.below(8)]);
  }
}

void run(const std::string& input) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

TEST(FuzzImport, CorpusIsWhatItClaimsToBe) {
  for (const std::size_t valid : {0u, 1u, 2u}) {
    const std::string file = corpus()[valid];
    const MeshFormat format = file[0] == 0 ? MeshFormat::kGlb : MeshFormat::kGltf;
    EXPECT_TRUE(import_text(std::string_view(file).substr(1), format)) << valid;
  }
}

TEST(FuzzImport, CorpusAndSeededMutationsKeepThePromises) {
  constexpr std::uint64_t kSeed = 20260101;
  Random random(kSeed);
  for (const std::string& seed : corpus()) {
    run(seed);
    for (int round = 0; round < 2000; ++round) {
      std::string mutant = seed;
      const std::uint64_t changes = 1 + random.below(4);
      for (std::uint64_t c = 0; c < changes && mutant.size() > 1; ++c) mutate(mutant, random);
      run(mutant);
    }
  }
}

}  // namespace
}  // namespace fracture::test
