// Fuzz target: a request message and the shared memory behind it, as an import worker gets them. The worker
// takes the request only where every byte of the input belongs to the mesh, to one file, or to the head that
// lists them.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>

#include "server/import_worker/protocol.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fracture;
  ImportRequest request;
  if (size < sizeof request) return 0;
  std::memcpy(&request, data, sizeof request);
  const std::span<const std::byte> input{reinterpret_cast<const std::byte*>(data) + sizeof request,
                                         size - sizeof request};
  const std::optional<ImportJob> job = parse_request(request, input);
  if (!job) return 0;
  std::vector<std::byte> again = input_head(job->mesh, job->files);
  again.insert(again.end(), job->mesh.begin(), job->mesh.end());
  for (const ImportFile& file : job->files) again.insert(again.end(), file.bytes.begin(), file.bytes.end());
  if (again.size() != input.size() || std::memcmp(again.data(), input.data(), input.size()) != 0)
    std::abort();
  return 0;
}
