// What an import worker gives up before it sees the first foreign byte.
#pragma once

#include <cstdint>

namespace fracture {

struct SandboxLimits {
  std::uint64_t memory_bytes = 0;  ///< of address space (RLIMIT_AS); 0, or under a sanitizer: no limit
  std::uint64_t output_bytes = 1ull << 30;  ///< of what it writes (RLIMIT_FSIZE)
};

struct SandboxReport {
  bool seccomp = false;
  int seccomp_errno = 0;  ///< why not
};

/// Limits on memory, output, files and processes; no core dumps, no new privileges, not traceable, ended with
/// its parent; then a seccomp filter with the few calls that computing needs. Calls that open files answer
/// EACCES, all others EPERM. Processor time is limited by the server, import by import. Throws
/// std::system_error where a limit other than seccomp cannot be set.
SandboxReport enter_sandbox(const SandboxLimits& limits);

}  // namespace fracture
