// Fuzz target: the first byte chooses the coding, the rest is a compressed body.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "server/http/content_coding.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture;
  constexpr std::uint64_t kLimit = 1u << 20;
  if (size < 1) return 0;
  const auto coding = data[0] == 'z' ? http::ContentCoding::kZstd : http::ContentCoding::kGzip;
  std::string body(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::string sent = body;
  MemoryBudget budget(4u << 20);
  MemoryBudget::Reservation reservation(budget);
  const auto decoding = http::decode_body(body, coding, kLimit, reservation, {});
  if (decoding.problem || decoding.no_room) {
    if (body != sent || (decoding.problem && decoding.problem->detail.empty())) std::abort();
  } else if (body.size() > kLimit) {
    std::abort();
  }
  return 0;
}
