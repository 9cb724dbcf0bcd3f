// Fuzz target: a request message with its shared memory, as an import worker receives them. The worker
// accepts the request only if every byte of the input belongs to the mesh, to exactly one file, or to the
// head that lists them.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>

#include "server/import_worker/protocol.hpp"

static volatile unsigned sum;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture;
  ImportRequest request;
  if (size < sizeof request) return 0;
  std::memcpy(&request, data, sizeof request);
  const std::span<const std::byte> input{reinterpret_cast<const std::byte*>(data) + sizeof request,
                                         size - sizeof request};
  const std::optional<ImportJob> job = parse_request(request, input);
  if (!job) return 0;
  std::uint64_t size_of_parts = input_head(job->mesh, job->files).size();
  const auto add = [&](std::span<const std::byte> part) {
    if (part.size() > input.size() || (!part.empty() && (part.data() - input.data()) % kInputAlignment != 0))
      std::abort();
    for (const std::byte byte : part) sum = sum + std::to_integer<unsigned>(byte);  // every byte can be read
    size_of_parts += aligned(part.size());
  };
  add(job->mesh);
  for (const ImportFile& file : job->files) add(file.bytes);
  if (size_of_parts != input.size()) std::abort();
  return 0;
}
