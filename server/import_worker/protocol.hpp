// What server and import worker say to each other over their socket pair (SOCK_SEQPACKET: whole messages).
// The bytes travel in shared memory whose descriptors go along.
//
//   worker ──WorkerHello──> server                                   once, with the sandbox in force
//   server ──ImportRequest + input, output──> worker                 input: see write_input()
//   worker ──ImportDone──> server                                    output: see mesh_codec.hpp
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/import/import.hpp"

namespace fracture {

inline constexpr std::uint32_t kProtocolVersion = 1;
inline constexpr int kWorkerSocket = 3;  ///< the worker's end, by number; beside it only 0, 1 and 2

/// Exit code of a worker that lacked memory where it could not say so: a destructor that allocates, say.
inline constexpr int kLackedMemory = 5;

struct WorkerHello {
  std::uint32_t version = kProtocolVersion;
  std::uint32_t seccomp = 0;  ///< 1: the filter is loaded; else seccomp_errno says why not
  std::int32_t seccomp_errno = 0;
};

struct ImportRequest {
  std::uint32_t version = kProtocolVersion;
  std::uint32_t format = 0;
  std::uint64_t input_bytes = 0;  ///< of the shared memory
  std::uint64_t max_triangles = 0, max_decoded_bytes = 0;
  std::uint32_t max_json_depth = 0;
  std::uint32_t reserved = 0;
};

struct ImportDone {
  std::uint32_t version = kProtocolVersion;
  std::uint32_t reserved = 0;
  std::uint64_t output_bytes = 0;
};

/// A request as the worker understands it: views into the input.
struct ImportJob {
  MeshFormat format = MeshFormat::kGlb;
  ImportLimits limits;
  std::span<const std::byte> mesh;
  std::vector<ImportFile> files;
};

/// Every part of the input begins at a multiple of this, as memory from an allocator does: formats align
/// their numbers within the file, and decoders read them in place.
inline constexpr std::uint64_t kInputAlignment = 16;
inline constexpr std::uint64_t aligned(std::uint64_t size) {
  return (size + kInputAlignment - 1) / kInputAlignment * kInputAlignment;
}

/// The head of the input: names and sizes. Behind it come the bytes of the mesh, then those of each file,
/// each part filled up to the alignment.
std::vector<std::byte> input_head(std::span<const std::byte> mesh, std::span<const ImportFile> files);

/// Nothing where the request does not fit its input: then it is not from our server.
std::optional<ImportJob> parse_request(const ImportRequest& request, std::span<const std::byte> input);

/// One message with at most two descriptors. False at the end of the connection and on every error.
bool send_message(int socket, const void* message, std::size_t size, std::span<const int> descriptors = {});

struct Received {
  bool whole = false;  ///< a message of exactly the size that was expected
  int descriptors[2] = {-1, -1};
};
/// Waits for a message. Descriptors are the caller's to close, also where the message is not whole.
Received receive_message(int socket, void* message, std::size_t size);

}  // namespace fracture
