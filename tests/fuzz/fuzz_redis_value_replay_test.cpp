// The fuzz target as a test: valid values and seeded mutations of them, before and after compression.
#include <gtest/gtest.h>
#include <zstd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/random.hpp"
#include "server/cache/entry.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace fracture {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes compressed(const Bytes& bytes) {
  Bytes value(ZSTD_compressBound(bytes.size()));
  value.resize(ZSTD_compress(value.data(), value.size(), bytes.data(), bytes.size(), 1));
  return value;
}

void change(Bytes& bytes, Random& random) {
  for (std::uint64_t changes = 1 + random.below(3); changes > 0; --changes)
    bytes[random.below(std::min<std::size_t>(bytes.size(), 80))] =
        static_cast<std::uint8_t>(random.below(256));
}

/// Runs a copy of exactly this size, so that the sanitizer detects the first read beyond it.
void run(const Bytes& value) {
  const Bytes exact(value.begin(), value.end());
  LLVMFuzzerTestOneInput(exact.data(), exact.size());
}

TEST(FuzzRedisValue, ValidValuesAndTheirMutationsAreDecodedOrRefused) {
  Random random(2026);
  for (int i = 0; i < 3'000; ++i) {
    // Some are larger than the target allows.
    const Bytes payload(random.below(i % 50 == 0 ? 100'000 : 300), 'p');
    const std::string head = encode_entry_head({"0123456789abcdef", "glb\nsha256:00", payload});
    Bytes entry(head.begin(), head.end());
    entry.insert(entry.end(), payload.begin(), payload.end());
    Bytes value = compressed(entry);
    run(value);
    change(value, random);
    if (random.below(4) == 0) value.resize(random.below(value.size() + 1));
    run(value);
    change(entry, random);
    run(compressed(entry));
  }
  run({});
  SUCCEED() << "the target aborts on a finding";
}

}  // namespace
}  // namespace fracture
