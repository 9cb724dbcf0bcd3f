#include "server/import_worker/worker_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <system_error>
#include <vector>

#include "server/import_worker/mesh_codec.hpp"

namespace fracture {
namespace {

/// How often a waiting import looks whether it is still wanted.
constexpr int kPollMilliseconds = 10;
constexpr std::chrono::seconds kStartTimeout{20};
/// Room in a reply for names, warnings and the text of an error.
constexpr std::uint64_t kSlack = 1u << 20;

[[noreturn]] void fail_to_start(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

/// The child's attributes: a session of its own (Ctrl-C on the server's terminal is the server's to handle),
/// no blocked and no ignored signals.
class SpawnAttributes {
 public:
  SpawnAttributes() {
    posix_spawnattr_init(&value);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&value, &none);
    posix_spawnattr_setsigdefault(&value, &all);
    posix_spawnattr_setflags(&value, POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~SpawnAttributes() { posix_spawnattr_destroy(&value); }
  posix_spawnattr_t value;
};

/// Its descriptors: the socket, and nothing else of the server's.
class Descriptors {
 public:
  explicit Descriptors(int socket) {
    posix_spawn_file_actions_init(&value);
    posix_spawn_file_actions_adddup2(&value, socket, kWorkerSocket);
    posix_spawn_file_actions_addopen(&value, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&value, 1, "/dev/null", O_WRONLY, 0);
#ifndef FRACTURE_SANITIZED  // whose reports must be seen
    posix_spawn_file_actions_addopen(&value, 2, "/dev/null", O_WRONLY, 0);
#endif
    posix_spawn_file_actions_addclosefrom_np(&value, kWorkerSocket + 1);
  }
  ~Descriptors() { posix_spawn_file_actions_destroy(&value); }
  posix_spawn_file_actions_t value;
};

}  // namespace

WorkerProcess::WorkerProcess(const WorkerProcessConfig& config) : cpu_(config.cpu) {
  try {
    start(config);
  } catch (...) {
    kill_and_reap();
    throw;
  }
}

void WorkerProcess::start(const WorkerProcessConfig& config) {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
    fail_to_start(errno, "a socket pair for an import worker");
  socket_ = Descriptor(ends[0]);
  // dup2 of a descriptor onto itself would keep its close-on-exec flag.
  Descriptor theirs(ends[1]);
  if (ends[1] == kWorkerSocket) theirs = Descriptor(::fcntl(ends[1], F_DUPFD_CLOEXEC, kWorkerSocket + 1));
  const SpawnAttributes attributes;
  const Descriptors descriptors(theirs.get());
  std::string program = config.program, memory = std::to_string(config.memory_bytes);
  char* const argv[] = {program.data(), memory.data(), nullptr};
  std::vector<char*> environment;
#ifdef FRACTURE_SANITIZED
  std::string options =
      std::string("ASAN_OPTIONS=") + (std::getenv("ASAN_OPTIONS") ?: "") + ":detect_leaks=0";
  environment.push_back(options.data());
#endif
  environment.push_back(nullptr);
  if (const int error = ::posix_spawn(&pid_, program.c_str(), &descriptors.value, &attributes.value, argv,
                                      environment.data());
      error != 0) {
    pid_ = -1;
    fail_to_start(error, "cannot start the import worker " + program);
  }
  theirs.reset();  // so that its death is the end of the connection
  Execution patience;
  patience.deadline = std::chrono::steady_clock::now() + kStartTimeout;
  bool said = false;
  try {
    said = wait_readable(patience) && receive_message(socket_.get(), &hello_, sizeof hello_).whole &&
           hello_.version == kProtocolVersion;
  } catch (const Interrupted&) {
  }
  if (!said)
    throw std::runtime_error("the import worker " + program +
                             " does not start: it is damaged, or of another version than the server");
}

WorkerProcess::~WorkerProcess() { kill_and_reap(); }

void WorkerProcess::kill_and_reap() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  while (::waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
}

/// RLIMIT_CPU counts from the start of the process, an import from now.
void WorkerProcess::allow_cpu() const {
  clockid_t clock{};
  timespec used{};
  if (cpu_.count() <= 0 || ::clock_getcpuclockid(pid_, &clock) != 0 || ::clock_gettime(clock, &used) != 0)
    return;
  rlimit limit{};
  if (::prlimit(pid_, RLIMIT_CPU, nullptr, &limit) != 0) return;
  // Only the soft limit: the hard one could not be raised again.
  limit.rlim_cur = std::min(static_cast<rlim_t>(used.tv_sec + 1 + cpu_.count()), limit.rlim_max);
  ::prlimit(pid_, RLIMIT_CPU, &limit, nullptr);
}

/// RLIMIT_AS counts what the process has, an import what it takes.
void WorkerProcess::allow_memory([[maybe_unused]] std::uint64_t bytes) const {
#ifndef FRACTURE_SANITIZED  // the sanitizers reserve terabytes
  rlimit limit{};
  std::uint64_t pages = 0;
  if (std::ifstream statm("/proc/" + std::to_string(pid_) + "/statm");
      !(statm >> pages) || ::prlimit(pid_, RLIMIT_AS, nullptr, &limit) != 0)
    return;
  const std::uint64_t has = pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  limit.rlim_cur = bytes == 0 ? limit.rlim_max : std::min<rlim_t>(has + bytes, limit.rlim_max);
  ::prlimit(pid_, RLIMIT_AS, &limit, nullptr);
#endif
}

bool WorkerProcess::wait_readable(const Execution& execution) const {
  for (;;) {
    pollfd fd{socket_.get(), POLLIN, 0};
    const int ready = ::poll(&fd, 1, kPollMilliseconds);
    if (ready > 0) return (fd.revents & POLLIN) != 0;
    if (ready < 0 && errno != EINTR) return false;
    execution.poll();
  }
}

Expected<Mesh> WorkerProcess::died(WorkerDeath how_at_least) {
  death_ = how_at_least;
  socket_.reset();
  // Its end of the socket is closed and it is dying, unless it lied: then it has to.
  int status = 0;
  pid_t reaped = 0;
  for (int k = 0; last_words_.empty() && k < 50 && (reaped = ::waitpid(pid_, &status, WNOHANG)) == 0; ++k)
    ::usleep(2000);
  if (reaped == pid_) {
    pid_ = -1;
    const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    if (signal == SIGXCPU) death_ = WorkerDeath::kCpuLimit;
    if (signal == SIGXFSZ) death_ = WorkerDeath::kSizeLimit;
    if (signal == 0 && WEXITSTATUS(status) == kLackedMemory) death_ = WorkerDeath::kMemoryLimit;
    last_words_ = signal != 0 ? "signal " + std::to_string(signal) + " (" + ::strsignal(signal) + ")"
                              : "exit code " + std::to_string(WEXITSTATUS(status));
  } else {
    kill_and_reap();
    if (last_words_.empty()) last_words_ = "silence";
  }
  switch (death_) {
    case WorkerDeath::kCpuLimit:
      return fail(ErrorCode::kImporterLimit,
                  "The importer needed more than the " + std::to_string(cpu_.count()) +
                      " seconds of processor time that one import may have.",
                  {}, {{"limit", "cpu"}, {"seconds", cpu_.count()}});
    case WorkerDeath::kMemoryLimit:
      return fail(
          ErrorCode::kImporterLimit,
          "The importer needed more memory for this file than one import may have. Send a smaller mesh, or "
          "raise the server's --import-memory.",
          {}, {{"limit", "memory"}});
    case WorkerDeath::kSizeLimit:
      return fail(ErrorCode::kImporterLimit, "The file unfolds to more than a mesh may have.", {},
                  {{"limit", "size"}});
    default:
      return fail(ErrorCode::kImporterCrashed,
                  "The process that read the file ended with " + last_words_ +
                      ": the file is damaged, or its reader has a defect. Other requests are not affected.");
  }
}

Expected<Mesh> WorkerProcess::import(std::span<const std::byte> mesh, MeshFormat format,
                                     std::span<const ImportFile> files, const ImportLimits& limits,
                                     const Execution& execution, std::uint64_t memory_bytes) {
  ++imports_;
  const Descriptor input = make_shared_memory("fracture-input"),
                   output = make_shared_memory("fracture-output");
  const std::vector<std::byte> head = input_head(mesh, files);
  ImportRequest request;
  request.format = static_cast<std::uint32_t>(format);
  request.max_triangles = limits.max_triangles;
  request.max_decoded_bytes = limits.max_decoded_bytes;
  request.max_json_depth = limits.max_json_depth;
  request.input_bytes = head.size();
  bool written = write_all(input.get(), head);
  const auto add_part = [&](std::span<const std::byte> bytes) {
    constexpr std::byte kZeros[kInputAlignment] = {};
    const std::uint64_t size = aligned(bytes.size());
    written = written && write_all(input.get(), bytes) &&
              write_all(input.get(), std::span(kZeros).first(size - bytes.size()));
    request.input_bytes += size;
  };
  add_part(mesh);
  for (const ImportFile& file : files) add_part(file.bytes);
  if (!written) throw std::bad_alloc();  // shared memory is full
  allow_cpu();
  allow_memory(memory_bytes);
  const int descriptors[] = {input.get(), output.get()};
  if (!send_message(socket_.get(), &request, sizeof request, descriptors)) return died(WorkerDeath::kCrash);
  ImportDone done;
  if (!wait_readable(execution)) return died(WorkerDeath::kCrash);
  const Received received = receive_message(socket_.get(), &done, sizeof done);
  const Descriptor unasked[] = {Descriptor(received.descriptors[0]), Descriptor(received.descriptors[1])};
  if (!received.whole || done.version != kProtocolVersion) return died(WorkerDeath::kCrash);
  // The arrays within the limit, what is added to complete them, and images as they came.
  if (done.output_bytes > 3 * limits.max_decoded_bytes + request.input_bytes + kSlack) {
    last_words_ = "a reply of " + std::to_string(done.output_bytes) + " bytes";
    return died(WorkerDeath::kSizeLimit);
  }
  const SealedBytes reply = SealedBytes::take(output.get(), done.output_bytes);
  try {
    if (!reply.good()) throw BadReply("the reply is shorter than announced");
    return decode_reply(reply.view(), limits);
  } catch (const BadReply& bad) {
    last_words_ = std::string("a reply that breaks a promise (") + bad.what() + ")";
    return died(WorkerDeath::kCrash);
  }
}

std::uint64_t WorkerProcess::resident_bytes() const {
  std::ifstream statm("/proc/" + std::to_string(pid_) + "/statm");
  std::uint64_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace fracture
