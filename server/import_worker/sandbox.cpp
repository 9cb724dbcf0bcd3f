#include "server/import_worker/sandbox.hpp"

#include <fcntl.h>
#include <seccomp.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>

namespace fracture {
namespace {

void limit(__rlimit_resource resource, rlim_t value) {
  rlimit both{};
  bool good = ::getrlimit(resource, &both) == 0;
  both.rlim_cur = both.rlim_max = std::min(value, both.rlim_max);
  good = good && ::setrlimit(resource, &both) == 0;
  if (!good) throw std::system_error(errno, std::generic_category(), "setrlimit in an import worker");
}

void set(int option, unsigned long value) {
  if (::prctl(option, value, 0, 0, 0) != 0)
    throw std::system_error(errno, std::generic_category(), "prctl in an import worker");
}

/// Negative errno of the first step that failed, 0 when the filter is loaded.
int load_filter() {
  const auto release = [](scmp_filter_ctx c) { seccomp_release(c); };
  const std::unique_ptr<void, decltype(release)> filter(seccomp_init(SCMP_ACT_ERRNO(EPERM)), release);
  if (!filter) return -ENOMEM;
  // Enough for every reader, measured over the models of Assimp; no call that names a file, a socket address
  // or a process.
  for (const int call : {SCMP_SYS(read),          SCMP_SYS(write),           SCMP_SYS(readv),
                         SCMP_SYS(writev),        SCMP_SYS(recvmsg),         SCMP_SYS(sendmsg),
                         SCMP_SYS(close),         SCMP_SYS(munmap),          SCMP_SYS(mremap),
                         SCMP_SYS(brk),           SCMP_SYS(madvise),         SCMP_SYS(futex),
                         SCMP_SYS(clock_gettime), SCMP_SYS(gettimeofday),    SCMP_SYS(getrandom),
                         SCMP_SYS(sched_yield),   SCMP_SYS(restart_syscall), SCMP_SYS(rt_sigreturn),
                         SCMP_SYS(exit),          SCMP_SYS(exit_group)})
    if (const int error = seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, 0); error != 0) return error;
#ifdef FRACTURE_SANITIZED  // which asks a pipe whether memory can be read
  for (const int call : {SCMP_SYS(pipe), SCMP_SYS(pipe2)})
    if (const int error = seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, 0); error != 0) return error;
#endif
  for (const int call : {SCMP_SYS(mmap), SCMP_SYS(mprotect)})  // memory, but no code
    if (const int error = seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, 1,
                                           SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0));
        error != 0)
      return error;
  for (const int call : {SCMP_SYS(open), SCMP_SYS(openat), SCMP_SYS(openat2), SCMP_SYS(creat)})
    if (const int error = seccomp_rule_add(filter.get(), SCMP_ACT_ERRNO(EACCES), call, 0); error != 0)
      return error;
  return seccomp_load(filter.get());
}

/// Where memory runs out, a reader of one file goes before the server of all. Raising it is always allowed;
/// where there is no /proc, nothing is lost.
void prefer_as_victim() {
  constexpr const char* kScore = "500";
  const int file = ::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
  if (file < 0) return;
  (void)!::write(file, kScore, std::strlen(kScore));
  ::close(file);
}

}  // namespace

SandboxReport enter_sandbox(const SandboxLimits& limits) {
  prefer_as_victim();
  set(PR_SET_PDEATHSIG, SIGKILL);
  set(PR_SET_DUMPABLE, 0);
  set(PR_SET_NO_NEW_PRIVS, 1);
#ifndef FRACTURE_SANITIZED  // the sanitizers reserve terabytes
  if (limits.memory_bytes > 0) limit(RLIMIT_AS, limits.memory_bytes);
#endif
  limit(RLIMIT_FSIZE, limits.output_bytes);
  limit(RLIMIT_NOFILE, 16);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_NPROC, 0);
  const int error = load_filter();
  return {error == 0, -error};
}

}  // namespace fracture
