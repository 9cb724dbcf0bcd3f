#include "server/import_worker/worker_process.hpp"

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/base/spawn.hpp"
#include "server/import_worker/mesh_codec.hpp"

namespace fracture {
namespace {

/// Bytes allowed in a reply for names, warnings and an error's text.
constexpr std::uint64_t kSlack = 1u << 20;

/// Like write_all(), with polls. Throws Interrupted.
bool write_with_polls(int fd, std::span<const std::byte> bytes, const Execution& execution) {
  while (!bytes.empty()) {
    execution.poll();
    const auto piece = bytes.first(std::min(bytes.size(), kBytesBetweenPolls));
    if (!write_all(fd, piece)) return false;
    bytes = bytes.subspan(piece.size());
  }
  return true;
}

InputDigest to_digest(std::string_view hex) {
  InputDigest digest{};
  hex.copy(digest.data(), digest.size());
  return digest;
}

/// Returns whether only the process itself can have caused this signal. Operators and a kernel that is short of memory send
/// other signals.
bool is_of_its_own_making(int signal) {
  switch (signal) {
    case SIGSEGV:
    case SIGBUS:
    case SIGABRT:
    case SIGFPE:
    case SIGILL:
    case SIGTRAP:
    case SIGSYS:
      return true;
    default:
      return false;
  }
}

std::chrono::microseconds processor_time_of(const rusage& used) {
  const auto sum = [](const timeval& a, const timeval& b) {
    return std::chrono::seconds(a.tv_sec + b.tv_sec) + std::chrono::microseconds(a.tv_usec + b.tv_usec);
  };
  return sum(used.ru_utime, used.ru_stime);
}

}  // namespace

Error no_room_to_read(const std::string& why) {
  return {.code = ErrorCode::kOverloaded,
          .detail = "The process that reads the file cannot run at the moment: " + why +
                    ". The file is not the cause.",
          .retry_after = std::chrono::seconds(5)};
}

WorkerProcess::WorkerProcess(ZygoteProcess& zygote, const WorkerProcessConfig& config)
    : cpu_(config.cpu), first_space_(zygote.hello().address_space) {
  ZygoteProcess::Forked forked = zygote.fork();
  pid_ = forked.pid;
  socket_ = std::move(forked.socket);
  group_ = std::move(forked.group);
  std::string problem;
  if (!receive_in_time(socket_.get(), &hello_, sizeof hello_) || hello_.version != kProtocolVersion)
    problem = "a forked import worker ended before it was ready";
  else if (config.require_sandbox && hello_.seccomp == 0)
    problem = "the sandbox of the import workers is required, but this machine allows no seccomp filter (" +
              std::generic_category().message(hello_.seccomp_errno) +
              "): allow seccomp and prctl in the container's own filter, or use --require-sandbox no to "
              "read files without this protection";
  if (problem.empty()) return;
  kill_and_reap();
  throw std::runtime_error(problem);
}

WorkerProcess::~WorkerProcess() { kill_and_reap(); }

void WorkerProcess::kill_and_reap() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  wait_for_end(pid_);
  pid_ = -1;
}

void WorkerProcess::stop() const {
  if (pid_ > 0) ::kill(pid_, SIGSTOP);
}

void WorkerProcess::go_on() const {
  if (pid_ > 0) ::kill(pid_, SIGCONT);
}

std::chrono::nanoseconds WorkerProcess::processor_time() const {
  clockid_t clock{};
  timespec used{};
  if (pid_ <= 0 || ::clock_getcpuclockid(pid_, &clock) != 0 || ::clock_gettime(clock, &used) != 0)
    return used_;
  return std::chrono::seconds(used.tv_sec) + std::chrono::nanoseconds(used.tv_nsec);
}

/// RLIMIT_AS limits the whole process, but `bytes` is only for the import. So the limit includes the memory that the process
/// already has.
void WorkerProcess::allow_memory([[maybe_unused]] std::uint64_t bytes) {
#ifndef FRACTURE_SANITIZED  // sanitizers reserve terabytes
  std::uint64_t has = first_space_;
  // Includes memory that earlier files have left behind. If /proc hides processes (hidepid), it hides the workers, because
  // they are not traceable. Then the amount of this memory is unknown, and the file gets less memory.
  if (std::uint64_t pages = 0; files_ > 1 || has == 0)
    if (std::ifstream statm("/proc/" + std::to_string(pid_) + "/statm"); statm >> pages)
      has = pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  rlimit limit{};
  bool limited = ::prlimit(pid_, RLIMIT_AS, nullptr, &limit) == 0 && (bytes == 0 || has > 0);
  limit.rlim_cur = bytes == 0 ? limit.rlim_max : std::min<rlim_t>(has + bytes, limit.rlim_max);
  had_less_ = bytes > 0 && limit.rlim_cur < has + bytes;
  limited = limited && ::prlimit(pid_, RLIMIT_AS, &limit, nullptr) == 0;
  if (!limited && ::kill(pid_, 0) == 0)
    throw std::runtime_error("the memory of an import process cannot be limited on this machine");
#endif
}

Expected<Mesh> WorkerProcess::died(WorkerDeath how_at_least) {
  death_ = how_at_least;
  used_ = processor_time();
  socket_.reset();
  // If the worker has closed its end of the socket, it is dying and only needs to be reaped. If it does not end soon, or if it
  // sent an invalid answer, it is killed below.
  int status = 0;
  rusage used{};
  pid_t reaped = 0;
  for (int k = 0; last_words_.empty() && k < 50 && (reaped = ::wait4(pid_, &status, WNOHANG, &used)) == 0;
       ++k)
    ::usleep(2000);
  if (reaped == pid_) {
    pid_ = -1;
    used_ = processor_time_of(used);
    const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    // The second limit on processor time kills a process that ignores the first one (sandbox.cpp).
    const bool over_time = cpu_.count() > 0 && processor_time_of(used) >= cpu_;
    if (signal == SIGXCPU || (signal == SIGKILL && over_time)) death_ = WorkerDeath::kCpuLimit;
    if (signal == SIGXFSZ) death_ = WorkerDeath::kSizeLimit;
    if (signal == 0 && WEXITSTATUS(status) == kLackedMemory) death_ = WorkerDeath::kMemoryLimit;
    if (signal == 0 && WEXITSTATUS(status) == kRefusedMemory) death_ = WorkerDeath::kNoRoom;
    if (signal != 0 && death_ == WorkerDeath::kCrash && !is_of_its_own_making(signal))
      death_ = WorkerDeath::kKilled;
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
                      " seconds of processor time that a single import may use. Send a smaller mesh.",
                  {}, {{"limit", "cpu"}, {"seconds", cpu_.count()}});
    case WorkerDeath::kMemoryLimit:
      return fail(
          ErrorCode::kImporterLimit,
          "The importer needed more memory for this file than a single import may use. Send a smaller mesh, or "
          "raise the server's --import-memory.",
          {}, {{"limit", "memory"}});
    case WorkerDeath::kSizeLimit:
      return fail(ErrorCode::kImporterLimit,
                  "The decoded file is larger than a mesh may be (--max-decoded). Send a smaller mesh.", {},
                  {{"limit", "size"}});
    case WorkerDeath::kNoRoom:
      return tl::unexpected<Error>(
          no_room_to_read("the system refused memory, although the import was within its limit "
                          "(--import-memory)"));
    case WorkerDeath::kKilled:
      return tl::unexpected<Error>(
          no_room_to_read("it was killed from outside with " + last_words_ +
                          ", by an operator or by a system that is short of memory"));
    default:
      return fail(ErrorCode::kImporterCrashed,
                  "The process that read the file ended with " + last_words_ +
                      ": the file is damaged, or its reader has a defect. Other requests are not affected.");
  }
}

Expected<Mesh> WorkerProcess::import(std::span<const std::byte> mesh, MeshFormat format,
                                     std::span<const ImportFile> files, std::string_view digest,
                                     const ImportLimits& limits, const Execution& execution,
                                     std::uint64_t memory_bytes) {
  ++files_;
  const Descriptor input = make_shared_memory("fracture-input"),
                   output = make_shared_memory("fracture-output");
  const std::vector<std::byte> head = input_head(mesh, files);
  ImportRequest request;
  request.format = static_cast<std::uint32_t>(format);
  request.digest = to_digest(digest);
  request.max_triangles = limits.max_triangles;
  request.max_decoded_bytes = limits.max_decoded_bytes;
  request.max_json_depth = limits.max_json_depth;
  request.input_bytes = head.size();
  bool written = write_all(input.get(), head);
  const auto add_part = [&](std::span<const std::byte> bytes) {
    constexpr std::byte kZeros[kInputAlignment] = {};
    const std::uint64_t size = aligned(bytes.size());
    written = written && write_with_polls(input.get(), bytes, execution) &&
              write_all(input.get(), std::span(kZeros).first(size - bytes.size()));
    request.input_bytes += size;
  };
  add_part(mesh);
  for (const ImportFile& file : files) add_part(file.bytes);
  if (!written) throw std::bad_alloc();  // shared memory is full
  seal(input.get());
  allow_memory(memory_bytes);
  const int descriptors[] = {input.get(), output.get()};
  if (!send_message(socket_.get(), &request, sizeof request, descriptors)) return died(WorkerDeath::kCrash);
  ImportDone done;
  if (!wait_for_message(socket_.get(), execution)) return died(WorkerDeath::kCrash);
  const Received received = receive_message(socket_.get(), &done, sizeof done);
  const Descriptor unasked[] = {Descriptor(received.descriptors[0]), Descriptor(received.descriptors[1])};
  if (!received.whole || done.version != kProtocolVersion) return died(WorkerDeath::kCrash);
  if (done.digest != request.digest) {
    last_words_ = "an answer to another file";
    return died(WorkerDeath::kCrash);
  }
  // The limit covers arrays within max_decoded_bytes, data that completes them, and images copied from the input.
  if (done.output_bytes > 3 * limits.max_decoded_bytes + request.input_bytes + kSlack) {
    last_words_ = "a reply of " + std::to_string(done.output_bytes) + " bytes";
    return died(WorkerDeath::kSizeLimit);
  }
  const SealedBytes reply = SealedBytes::take(output.get(), done.output_bytes, execution);
  try {
    if (!reply.good()) throw BadReply("the reply is shorter than announced");
    return decode_reply(reply.view(), limits, execution);
  } catch (const BadReply& bad) {
    last_words_ = std::string("an invalid reply (") + bad.what() + ")";
    return died(WorkerDeath::kCrash);
  }
}

}  // namespace fracture
