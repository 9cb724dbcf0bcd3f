// What an import process gives up, in two steps: the zygote what no fork of it needs, each worker the rest,
// before it sees the first foreign byte.
#pragma once

#include <cstdint>
#include <vector>

struct sock_filter;

namespace fracture {

struct SandboxLimits {
  std::uint64_t memory_bytes = 0;  ///< of address space (RLIMIT_AS); 0, or under a sanitizer: no limit
  std::uint64_t cpu_seconds = 0;   ///< of processor time (RLIMIT_CPU); 0: no limit
  std::uint64_t output_bytes = 1ull << 30;  ///< of what it writes (RLIMIT_FSIZE)
};

/// The seccomp filter with the few calls that computing needs. Calls that open files answer EACCES, all
/// others EPERM. Built once, by the zygote: to build it takes longer than to fork and to load it.
class SyscallFilter {
 public:
  /// Where the filter cannot be built, load() says why not.
  SyscallFilter();
  ~SyscallFilter();
  SyscallFilter(const SyscallFilter&) = delete;
  SyscallFilter& operator=(const SyscallFilter&) = delete;
  /// For the calling thread and those it starts, for good. 0, or an errno.
  int load() const;

 private:
  std::vector<sock_filter> program_;
  int error_ = 0;
};

/// For the zygote: no core dumps, no new privileges, not traceable, ended with its parent; Landlock (Salaün,
/// landlock(7)) where the kernel has it, a second layer behind the filter's. Returns Landlock's version or 0.
/// Throws std::system_error where anything else cannot be had.
int enter_zygote_sandbox();

struct SandboxReport {
  bool seccomp = false;
  int seccomp_errno = 0;  ///< why not
};

/// For a fork of the zygote: limits on memory, processor time, output, files and processes; ended with its
/// parent, which a fork does not inherit; then the filter. Throws std::system_error where a limit other than
/// seccomp cannot be set.
SandboxReport enter_worker_sandbox(const SandboxLimits& limits, const SyscallFilter& filter);

}  // namespace fracture
