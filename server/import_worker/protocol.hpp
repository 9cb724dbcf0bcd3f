// What server, zygote and import workers say to each other over socket pairs (SOCK_SEQPACKET: whole
// messages). The zygote is the started program, ready to read files; a worker is a fork of it that reads them,
// of strangers one.
// The bytes of files travel between server and worker alone, in shared memory whose descriptors go along.
//
//   zygote ──ZygoteHello──> server                                   once, ready to fork
//   server ──ForkRequest + the worker's socket──> zygote
//   zygote ──ForkDone──> server                                      the worker is the server's own child
//
//   worker ──WorkerHello──> server                                   once, with the sandbox in force
//   server ──ImportRequest + input, output──> worker                 input: see input_head()
//   worker ──ImportDone──> server                                    output: see mesh_codec.hpp
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/execution.hpp"
#include "common/import/import_input.hpp"

namespace fracture {

inline constexpr std::uint32_t kProtocolVersion = 3;
inline constexpr int kWorkerSocket = 3;  ///< the child's end, by number; beside it only 0, 1 and 2

struct ZygoteHello {
  std::uint32_t version = kProtocolVersion;
  /// Version of Landlock whose rules deny files and TCP in it and in its forks; 0: this kernel has none.
  std::uint32_t landlock = 0;
  /// Bytes of its address space, which each fork has before it reads a file; 0: not known.
  std::uint64_t address_space = 0;
};

struct ForkRequest {
  std::uint32_t version = kProtocolVersion;
};

struct ForkDone {
  std::uint32_t version = kProtocolVersion;
  std::int32_t pid = -1;
  std::int32_t error = 0;  ///< errno where pid is -1
};

/// Exit code of a worker that lacked memory where it could not say so: a destructor that allocates, say.
inline constexpr int kLackedMemory = 5;
/// Exit code of a worker that the system refused memory which its own limit allows.
inline constexpr int kRefusedMemory = 6;

struct WorkerHello {
  std::uint32_t version = kProtocolVersion;
  std::uint32_t seccomp = 0;  ///< 1: the filter is loaded; else seccomp_errno says why not
  std::int32_t seccomp_errno = 0;
};

/// The digest of an input in 64 hex digits, as the server's caches call it.
using InputDigest = std::array<char, 64>;

struct ImportRequest {
  std::uint32_t version = kProtocolVersion;
  std::uint32_t format = 0;
  InputDigest digest{};
  std::uint64_t input_bytes = 0;  ///< of the shared memory
  std::uint64_t max_triangles = 0, max_decoded_bytes = 0;
  std::uint32_t max_json_depth = 0;
  std::uint32_t reserved = 0;
};

struct ImportDone {
  std::uint32_t version = kProtocolVersion;
  std::uint32_t reserved = 0;
  InputDigest digest{};  ///< of the request that this answers
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

/// Waits for a message; false when the other side has gone instead. Throws Interrupted.
bool wait_for_message(int socket, const Execution& execution);

}  // namespace fracture
