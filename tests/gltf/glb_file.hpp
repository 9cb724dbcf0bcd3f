// The container split by hand: the tests' own reading of the GLB specification.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

namespace fracture::test {

struct Glb {
  nlohmann::json document;
  std::vector<std::uint8_t> binary;

  explicit Glb(const std::vector<std::uint8_t>& bytes) {
    const auto u32 = [&](std::size_t at) {
      std::uint32_t value = 0;
      std::memcpy(&value, &bytes.at(at), 4);
      return value;
    };
    EXPECT_EQ(u32(0), 0x46546c67u);
    EXPECT_EQ(u32(4), 2u);
    EXPECT_EQ(u32(8), bytes.size());
    const std::uint32_t size = u32(12);
    EXPECT_EQ(u32(16), 0x4e4f534au);
    EXPECT_EQ(size % 4, 0u);
    document = nlohmann::json::parse(bytes.begin() + 20, bytes.begin() + 20 + size);
    if (bytes.size() > 20 + size) {
      EXPECT_EQ(u32(24 + size), 0x004e4942u);
      EXPECT_EQ(u32(20 + size) % 4, 0u);
      EXPECT_EQ(28 + size + u32(20 + size), bytes.size());
      binary.assign(bytes.begin() + 28 + size, bytes.end());
    }
  }
  /// The bytes of an accessor (they are tightly packed here).
  template <class T>
  std::vector<T> read(const nlohmann::json& accessor_index) const {
    const nlohmann::json& accessor = document["accessors"].at(accessor_index.get<std::size_t>());
    const nlohmann::json& view = document["bufferViews"].at(accessor["bufferView"].get<std::size_t>());
    const std::size_t at = view.value("byteOffset", 0u) + accessor.value("byteOffset", 0u);
    std::vector<T> values(accessor["count"].get<std::size_t>());
    EXPECT_LE(accessor.value("byteOffset", 0u) + values.size() * sizeof(T),
              view["byteLength"].get<std::size_t>());
    std::memcpy(values.data(), &binary.at(at), values.size() * sizeof(T));
    return values;
  }
};

}  // namespace fracture::test
