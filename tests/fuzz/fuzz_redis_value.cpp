// Fuzz target: a value that Redis returns, with and without farm keys. RedisCache::decoded must ask for the room that it
// uses, and accept only bytes that encode_entry_head writes. With keys, it must accept the same values if they are signed,
// and none that are not.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/cache/redis_cache.hpp"

namespace {

using namespace fracture;

constexpr std::uint64_t kMostBytes = 64u << 10;

RedisConfig config_with(const FarmKeys& keys) {
  RedisConfig config;
  config.address = "/nowhere";
  config.keys = keys;
  config.max_value_bytes = 32u << 10;
  config.max_entry_bytes = kMostBytes;
  return config;
}

void demand(bool holds) {
  if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const FarmKeys keys = *FarmKeys::parse(std::string(64, 'a'));
  static const RedisCache plain(config_with({})), signing(config_with(keys));
  const std::span<const std::uint8_t> value(data, size);
  const std::string key = "0123456789abcdef";
  std::optional<std::uint64_t> asked;
  bool no_room = false;
  const auto stored = plain.decoded(
      value, key,
      [&asked](std::uint64_t bytes) {
        asked = bytes;
        return true;
      },
      no_room);
  demand(!no_room && asked.value_or(0) <= kMostBytes);
  if (stored) {
    demand(asked == stored->bytes.size() && stored->entry.key == key);
    demand(encode_entry_head(stored->entry).size() + stored->entry.payload.size() == stored->bytes.size());
  }
  demand(!plain.decoded(
      value, key, [](std::uint64_t) { return false; }, no_room));
  demand(no_room == asked.has_value());
  no_room = false;

  demand(!signing.decoded(value, key, {}, no_room) && !no_room);
  const std::string head = keys.head({"redis", key, 0}, {value});
  std::vector<std::uint8_t> sealed(head.begin(), head.end());
  sealed.insert(sealed.end(), value.begin(), value.end());
  const auto opened = signing.decoded(sealed, key, {}, no_room);
  demand(opened.has_value() == stored.has_value());
  demand(!opened || opened->bytes == stored->bytes);
  return 0;
}
