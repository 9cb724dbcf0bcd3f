#include "server/import_worker/zygote_process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstdlib>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "common/base/spawn.hpp"

namespace fracture {
namespace {

constexpr std::chrono::seconds kStartTimeout{20};
#ifndef FRACTURE_SANITIZED
/// Enables huge pages. Every worker touches its memory for the first time, and each page costs a fault: for 16 MiB, 4,096
/// faults and 5 ms, but only 8 faults and 1 ms with huge pages. The system must allow them
/// ("madvise" or "always" in /sys/kernel/mm/transparent_hugepage/enabled).
constexpr const char* kTunables = "GLIBC_TUNABLES=glibc.malloc.hugetlb=1";
#endif

[[noreturn]] void fail_to_start(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

/// The child gets its own session, so that only the server handles Ctrl-C on its terminal. It gets the socket, and none of the
/// server's other descriptors. No signals are blocked or ignored.
void describe_child(Spawn& spawn, int socket) {
  spawn.reset_signals();
  spawn.lead_session();
  spawn.give(socket, kWorkerSocket);
  spawn.open(0, "/dev/null", O_RDONLY);
  spawn.open(1, "/dev/null", O_WRONLY);
#ifndef FRACTURE_SANITIZED  // sanitizer reports must stay visible
  spawn.open(2, "/dev/null", O_WRONLY);
#endif
  spawn.close_from(kWorkerSocket + 1);
}

/// Returns the server's end and the child's end.
std::pair<Descriptor, Descriptor> socket_pair() {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
    fail_to_start(errno, "cannot create a socket pair for an import worker");
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

}  // namespace

bool receive_in_time(int socket, void* message, std::size_t size) {
  Execution patience;
  patience.deadline = std::chrono::steady_clock::now() + kStartTimeout;
  try {
    if (!wait_for_message(socket, patience)) return false;
  } catch (const Interrupted&) {
    return false;
  }
  const Received received = receive_message(socket, message, size);
  const Descriptor unasked[] = {Descriptor(received.descriptors[0]), Descriptor(received.descriptors[1])};
  return received.whole;
}

ProcessGroup::~ProcessGroup() {
  for (;;) {
    const pid_t pid = ::waitpid(-leader_, nullptr, WNOHANG);
    if (pid > 0 || (pid < 0 && errno == EINTR)) continue;
    if (pid < 0) return;
    // A child of this process is still in the group, so the id cannot belong to another group by now.
    ::kill(-leader_, SIGKILL);
    wait_for_end(-leader_);
  }
}

ZygoteProcess::ZygoteProcess(const WorkerProcessConfig& config) {
  try {
    start(config);
  } catch (...) {
    kill_and_reap();
    throw;
  }
}

void ZygoteProcess::start(const WorkerProcessConfig& config) {
  auto [ours, theirs] = socket_pair();
  socket_ = std::move(ours);
  // dup2() of a descriptor onto itself would keep its close-on-exec flag.
  if (theirs.get() == kWorkerSocket)
    theirs = Descriptor(::fcntl(theirs.get(), F_DUPFD_CLOEXEC, kWorkerSocket + 1));
  Spawn spawn;
  describe_child(spawn, theirs.get());
#ifdef FRACTURE_SANITIZED
  const std::vector<std::string> variables{std::string("ASAN_OPTIONS=") +
                                           (std::getenv("ASAN_OPTIONS") ?: "") + ":detect_leaks=0"};
#else
  const std::vector<std::string> variables{kTunables};
#endif
  if (const int error = spawn.start(
          config.program,
          {config.program, std::to_string(config.memory_bytes), std::to_string(config.cpu.count())},
          &variables, pid_);
      error != 0) {
    pid_ = -1;
    fail_to_start(error, "cannot start the import worker " + config.program);
  }
  group_ = std::make_shared<ProcessGroup>(pid_);
  theirs.reset();  // so that the connection ends when the child dies
  if (!receive_in_time(socket_.get(), &hello_, sizeof hello_) || hello_.version != kProtocolVersion)
    throw std::runtime_error("the import worker " + config.program +
                             " does not start: it is damaged, or its version differs from the server's");
}

ZygoteProcess::~ZygoteProcess() { kill_and_reap(); }

void ZygoteProcess::kill_and_reap() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  wait_for_end(pid_);
  pid_ = -1;
}

ZygoteProcess::Forked ZygoteProcess::fork() {
  auto [ours, theirs] = socket_pair();
  const ForkRequest request;
  const int descriptors[] = {theirs.get()};
  ForkDone done;
  if (!send_message(socket_.get(), &request, sizeof request, descriptors) ||
      !receive_in_time(socket_.get(), &done, sizeof done) || done.version != kProtocolVersion)
    throw std::runtime_error("the process that forks the import workers has ended");
  if (done.pid <= 0) fail_to_start(done.error, "an import worker cannot be forked");
  ++forks_;
  return {done.pid, std::move(ours), group_};
}

}  // namespace fracture
