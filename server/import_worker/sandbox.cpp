#include "server/import_worker/sandbox.hpp"

#include <fcntl.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
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

#include "server/import_worker/landlock.hpp"
#include "server/import_worker/shared_memory.hpp"

namespace fracture {
namespace {

void limit(__rlimit_resource resource, rlim_t soft, rlim_t hard) {
  rlimit both{};
  bool good = ::getrlimit(resource, &both) == 0;
  both.rlim_max = std::min(hard, both.rlim_max);
  both.rlim_cur = std::min(soft, both.rlim_max);
  good = good && ::setrlimit(resource, &both) == 0;
  if (!good) throw std::system_error(errno, std::generic_category(), "setrlimit in an import worker");
}

void limit(__rlimit_resource resource, rlim_t value) { limit(resource, value, value); }

void set(int option, unsigned long value) {
  if (::prctl(option, value, 0, 0, 0) != 0)
    throw std::system_error(errno, std::generic_category(), "prctl in an import worker");
}

/// Adds the rules. Returns 0, or the negative errno of the first rule that was refused.
int add_rules(scmp_filter_ctx filter) {
  // These calls are enough for every reader, as measured over Assimp's test models. None of them names a file, a socket
  // address or a process.
  for (const int call : {SCMP_SYS(read),          SCMP_SYS(write),           SCMP_SYS(readv),
                         SCMP_SYS(writev),        SCMP_SYS(recvmsg),         SCMP_SYS(sendmsg),
                         SCMP_SYS(close),         SCMP_SYS(munmap),          SCMP_SYS(mremap),
                         SCMP_SYS(brk),           SCMP_SYS(madvise),         SCMP_SYS(futex),
                         SCMP_SYS(clock_gettime), SCMP_SYS(gettimeofday),    SCMP_SYS(getrandom),
                         SCMP_SYS(sched_yield),   SCMP_SYS(restart_syscall), SCMP_SYS(rt_sigreturn),
                         SCMP_SYS(exit),          SCMP_SYS(exit_group)})
    if (const int error = seccomp_rule_add(filter, SCMP_ACT_ALLOW, call, 0); error != 0) return error;
#ifdef FRACTURE_SANITIZED  // sanitizers use a pipe to check whether memory is readable, and look for the signal stack at each throw
  for (const int call : {SCMP_SYS(pipe), SCMP_SYS(pipe2), SCMP_SYS(sigaltstack)})
    if (const int error = seccomp_rule_add(filter, SCMP_ACT_ALLOW, call, 0); error != 0) return error;
#endif
  for (const int call : {SCMP_SYS(mmap), SCMP_SYS(mprotect)})  // memory that is not executable
    if (const int error =
            seccomp_rule_add(filter, SCMP_ACT_ALLOW, call, 1, SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0));
        error != 0)
      return error;
  for (const int call : {SCMP_SYS(open), SCMP_SYS(openat), SCMP_SYS(openat2), SCMP_SYS(creat)})
    if (const int error = seccomp_rule_add(filter, SCMP_ACT_ERRNO(EACCES), call, 0); error != 0) return error;
  return 0;
}

/// Raises the out-of-memory score. If memory runs out, the kernel should end the reader of one file rather than the server.
/// Raising the score is always allowed, and a failure without /proc does no harm.
void prefer_as_victim() {
  constexpr const char* kScore = "500";
  const int file = ::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
  if (file < 0) return;
  (void)!::write(file, kScore, std::strlen(kScore));
  ::close(file);
}

}  // namespace

SyscallFilter::SyscallFilter() {
  const auto release = [](scmp_filter_ctx c) { seccomp_release(c); };
  const std::unique_ptr<void, decltype(release)> filter(seccomp_init(SCMP_ACT_ERRNO(EPERM)), release);
  error_ = filter ? -add_rules(filter.get()) : ENOMEM;
  if (error_ != 0) return;
  const Descriptor file = make_shared_memory("fracture-filter");  // libseccomp can only write to a descriptor
  error_ = -seccomp_export_bpf(filter.get(), file.get());
  const off_t size = error_ == 0 ? ::lseek(file.get(), 0, SEEK_END) : 0;
  program_.resize(static_cast<std::size_t>(std::max<off_t>(size, 0)) / sizeof(sock_filter));
  const std::size_t bytes = program_.size() * sizeof(sock_filter);
  if (error_ == 0 && ::pread(file.get(), program_.data(), bytes, 0) != static_cast<ssize_t>(bytes))
    error_ = EIO;
}

SyscallFilter::~SyscallFilter() = default;

int SyscallFilter::load() const {
  if (error_ != 0) return error_;
  sock_fprog program{static_cast<unsigned short>(program_.size()), const_cast<sock_filter*>(program_.data())};
  return ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program, 0, 0) == 0 ? 0 : errno;
}

int enter_zygote_sandbox() {
  prefer_as_victim();  // forks inherit this
  set(PR_SET_PDEATHSIG, SIGKILL);
  set(PR_SET_DUMPABLE, 0);
  set(PR_SET_NO_NEW_PRIVS, 1);
  limit(RLIMIT_CORE, 0);
  return deny_files_by_landlock();
}

SandboxReport enter_worker_sandbox(const SandboxLimits& limits, const SyscallFilter& filter) {
  set(PR_SET_PDEATHSIG, SIGKILL);
#ifndef FRACTURE_SANITIZED  // sanitizers reserve terabytes
  if (limits.memory_bytes > 0) limit(RLIMIT_AS, limits.memory_bytes);
#endif
  // SIGXCPU ends the process and tells why. If a taken-over process ignores it, SIGKILL follows a second later.
  if (limits.cpu_seconds > 0) limit(RLIMIT_CPU, limits.cpu_seconds, limits.cpu_seconds + 1);
  limit(RLIMIT_FSIZE, limits.output_bytes);
  limit(RLIMIT_NOFILE, 16);
  limit(RLIMIT_NPROC, 0);
  const int error = filter.load();
  return {error == 0, error};
}

}  // namespace fracture
