// The sandbox of an import process, which has two steps. The zygote gives up what none of its forks needs. Each worker gives
// up the rest before it sees the first byte of a file.
#pragma once

#include <cstdint>
#include <vector>

struct sock_filter;

namespace fracture {

struct SandboxLimits {
  std::uint64_t memory_bytes = 0;           ///< address space (RLIMIT_AS); 0, or under a sanitizer: no limit
  std::uint64_t cpu_seconds = 0;            ///< processor time (RLIMIT_CPU); 0: no limit
  std::uint64_t output_bytes = 1ull << 30;  ///< size of the output (RLIMIT_FSIZE)
};

/// The seccomp filter, which allows the few system calls that computing needs. Calls that open files fail with EACCES, and all
/// others with EPERM. The zygote builds the filter once, because building takes longer than forking and loading the filter.
class SyscallFilter {
 public:
  /// Builds the filter. If that fails, load() returns the error.
  SyscallFilter();
  ~SyscallFilter();
  SyscallFilter(const SyscallFilter&) = delete;
  SyscallFilter& operator=(const SyscallFilter&) = delete;
  /// Applies the filter permanently to the calling thread and to threads that it starts. Returns 0 or an errno.
  int load() const;

 private:
  std::vector<sock_filter> program_;
  int error_ = 0;
};

/// Sandboxes the zygote: no core dumps, no new privileges, not traceable, and it ends with its parent. If the kernel has
/// Landlock (Salaün, landlock(7)), it is a second layer in addition to the filter. Returns the version of Landlock, or 0.
/// Throws std::system_error if any other protection is not available.
int enter_zygote_sandbox();

struct SandboxReport {
  bool seccomp = false;
  int seccomp_errno = 0;  ///< the error, if the filter was not loaded
};

/// Sandboxes a fork of the zygote. Limits memory, processor time, output, files and processes, then loads the filter. Also
/// makes the fork end with its parent, because a fork does not inherit that setting. Throws std::system_error if a limit
/// other than seccomp cannot be set.
SandboxReport enter_worker_sandbox(const SandboxLimits& limits, const SyscallFilter& filter);

}  // namespace fracture
