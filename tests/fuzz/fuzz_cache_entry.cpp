// Fuzz target: the decoder of cache entries. decode_entry must read nothing beyond the bytes that a disk or a
// Redis returns. The bytes it accepts must be exactly those that encode_entry_head writes.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "server/cache/entry.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture;
  const auto entry = decode_entry({data, size}, "0123456789abcdef");
  if (!entry) return 0;
  const std::string head = encode_entry_head(*entry);
  if (head.size() + entry->payload.size() != size || std::memcmp(head.data(), data, head.size()) != 0)
    std::abort();
  return 0;
}
