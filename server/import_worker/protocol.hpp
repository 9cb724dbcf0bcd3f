// The messages between server, zygote and import workers, over socket pairs (SOCK_SEQPACKET, which keeps messages whole).
// The zygote is the program that the server starts. A worker is a fork of the zygote, and reads files. The bytes of files go
// only between server and worker, in shared memory whose descriptors are sent with the messages.
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
inline constexpr int kWorkerSocket = 3;  ///< the child's socket; it has only descriptors 0 to 3

struct ZygoteHello {
  std::uint32_t version = kProtocolVersion;
  /// Version of Landlock that denies files and TCP to the zygote and its forks; 0: not available.
  std::uint32_t landlock = 0;
  /// Bytes of the zygote's address space, with which each fork begins; 0: not known.
  std::uint64_t address_space = 0;
};

struct ForkRequest {
  std::uint32_t version = kProtocolVersion;
};

struct ForkDone {
  std::uint32_t version = kProtocolVersion;
  std::int32_t pid = -1;
  std::int32_t error = 0;  ///< errno if pid is -1
};

/// Exit code of a worker that lacked memory and could not reply (in a destructor that allocates, for example).
inline constexpr int kLackedMemory = 5;
/// Exit code of a worker to which the system refused memory that its own limit would allow.
inline constexpr int kRefusedMemory = 6;

struct WorkerHello {
  std::uint32_t version = kProtocolVersion;
  std::uint32_t seccomp = 0;  ///< 1: the filter is loaded; otherwise seccomp_errno says why not
  std::int32_t seccomp_errno = 0;
};

/// An input's digest as 64 hex digits, as in the server's cache keys.
using InputDigest = std::array<char, 64>;

struct ImportRequest {
  std::uint32_t version = kProtocolVersion;
  std::uint32_t format = 0;
  InputDigest digest{};
  std::uint64_t input_bytes = 0;  ///< size of the input in shared memory
  std::uint64_t max_triangles = 0, max_decoded_bytes = 0;
  std::uint32_t max_json_depth = 0;
  std::uint32_t reserved = 0;
};

struct ImportDone {
  std::uint32_t version = kProtocolVersion;
  std::uint32_t reserved = 0;
  InputDigest digest{};  ///< digest in the request that this answers
  std::uint64_t output_bytes = 0;
};

/// A parsed request. Its spans are views into the input.
struct ImportJob {
  MeshFormat format = MeshFormat::kGlb;
  ImportLimits limits;
  std::span<const std::byte> mesh;
  std::vector<ImportFile> files;
};

/// Alignment of each part of the input, the same as that of allocated memory. Formats align numbers within a file, and
/// decoders read them in place.
inline constexpr std::uint64_t kInputAlignment = 16;
inline constexpr std::uint64_t aligned(std::uint64_t size) {
  return (size + kInputAlignment - 1) / kInputAlignment * kInputAlignment;
}

/// Returns the head of the input, with names and sizes. The bytes of the mesh and then of each file must follow. Each part is
/// padded to the alignment.
std::vector<std::byte> input_head(std::span<const std::byte> mesh, std::span<const ImportFile> files);

/// Parses a request. Returns nothing if the request does not match its input; then it is not from our server.
std::optional<ImportJob> parse_request(const ImportRequest& request, std::span<const std::byte> input);

/// Sends one message with at most two descriptors. Returns false if the connection has ended, and on any error.
bool send_message(int socket, const void* message, std::size_t size, std::span<const int> descriptors = {});

struct Received {
  bool whole = false;  ///< the message has exactly the expected size
  int descriptors[2] = {-1, -1};
};
/// Waits for a message and reads it. The caller must close the descriptors, even if the message is not whole.
Received receive_message(int socket, void* message, std::size_t size);

/// Waits for a message. Returns false if the other side has closed the connection. Throws Interrupted.
bool wait_for_message(int socket, const Execution& execution);

}  // namespace fracture
