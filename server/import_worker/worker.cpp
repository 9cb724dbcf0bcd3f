#include "server/import_worker/worker.hpp"

#include <malloc.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>

#include "common/import/import.hpp"
#include "server/import_worker/mesh_codec.hpp"
#include "server/import_worker/shared_memory.hpp"

namespace fracture {
namespace {

constexpr int kDone = 0, kNoServer = 2, kNoSandbox = 3, kBadRequest = 4;

/// Maps the input read-only while it lives.
class Input {
 public:
  Input(int fd, std::uint64_t size) : size_(size) {
    if (size > 0) at_ = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd, 0);
  }
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;
  ~Input() {
    if (good() && size_ > 0) ::munmap(at_, size_);
  }
  bool good() const { return at_ != MAP_FAILED; }
  std::span<const std::byte> view() const { return {static_cast<const std::byte*>(at_), size_}; }

 private:
  std::uint64_t size_;
  void* at_ = nullptr;
};

/// Memory has run out since this was last set to false. It is needed because readers catch exceptions and then call a file
/// damaged when memory was short.
bool lacked_memory = false;

/// Returns whether this much address space can be mapped. Pages that are not writable need no memory.
bool can_map(std::size_t bytes, int protection) {
  void* const at = ::mmap(nullptr, bytes, protection, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (at == MAP_FAILED) return false;
  ::munmap(at, bytes);
  return true;
}

/// Returns whether the system refuses memory that RLIMIT_AS would allow. Then the file is not to blame: all processes
/// together have used up the memory, or there is another limit (RLIMIT_DATA).
bool system_lacks_memory() {
  constexpr std::size_t kLeast = 64u << 10, kMost = 1u << 30;
  std::size_t most = 0;
  for (std::size_t size = kLeast; size <= kMost && can_map(size, PROT_NONE); size *= 2) most = size;
  return most > 0 && !can_map(most, PROT_READ | PROT_WRITE);
}

/// Ends the process with an exit code that tells the server why memory was missing.
[[noreturn]] void end_without_memory() { ::_exit(system_lacks_memory() ? kRefusedMemory : kLackedMemory); }

void no_memory() {
  lacked_memory = true;
  if (system_lacks_memory()) ::_exit(kRefusedMemory);
  throw std::bad_alloc();
}

/// The terminate handler. A parsed JSON value allocates memory while it is destroyed (nlohmann::json flattens nested values),
/// and if that fails, the program ends. This is not a defect of a reader.
[[noreturn]] void ended() {
  if (lacked_memory) end_without_memory();
  std::abort();
}

std::vector<std::byte> reply_to(const ImportFunction& import, const ImportJob& job) {
  lacked_memory = false;
  try {
    const Expected<Mesh> imported = import(job);
    if (imported || !lacked_memory) return encode_reply(imported);
  } catch (const std::bad_alloc&) {
  } catch (const std::length_error&) {  // a vector was to grow beyond the address space
  }
  return encode_reply(fail(
      ErrorCode::kImporterLimit,
      "The importer needed more memory for this file than a single import may use. Send a smaller mesh, or "
      "raise the server's --import-memory.",
      {}, {{"limit", "memory"}}));
}

/// Calls each kind of reader once; of Assimp's, the smallest. A reader's first call loads locale facets, lazily bound symbols
/// and static tables, which must happen now, while files can still be read.
void warm_up(const ImportFunction& import) {
  const std::string_view obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  const std::string_view gltf =
      R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[]}]})";
  const std::string_view raw = "0 0 0 1 0 0 0 1 0\n0 0 0 0 0 1 1 0 0\n0 0 0 0 1 0 0 0 1\n1 0 0 0 0 1 0 1 0\n";
  for (const auto& [format, text] : {std::pair{MeshFormat::kObj, obj}, std::pair{MeshFormat::kGltf, gltf},
                                     std::pair{MeshFormat::kRaw, raw}})
    (void)encode_reply(import({format, {}, std::as_bytes(std::span(text)), {}}));
}

/// Returns the size of this process's address space in bytes; 0 if there is no /proc.
std::uint64_t address_space() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// Reserves untouched memory on the heap for the lists of a reader, and keeps it between files. If the system has huge pages,
/// this memory uses them: 16 MiB then takes 8 page faults instead of 4096.
void make_room() {
  constexpr std::size_t kRoom = 20u << 20, kMost = 32u << 20, kPage = 2u << 20;
  ::mallopt(M_MMAP_THRESHOLD, kMost);
  ::mallopt(M_TRIM_THRESHOLD, 2 * kMost);
  char* volatile room = static_cast<char*>(std::malloc(kRoom));
  if (room) {
    const std::size_t before = (kPage - reinterpret_cast<std::uintptr_t>(room) % kPage) % kPage;
    (void)::madvise(room + before, (kRoom - before) / kPage * kPage, MADV_HUGEPAGE);
  }
  std::free(room);
}

bool answer(int socket, const ImportRequest& request, int input_fd, int output_fd,
            const ImportFunction& import) {
  ImportDone done;
  {
    const Input input(input_fd, request.input_bytes);
    if (!input.good()) end_without_memory();  // mapping our own descriptor fails only if there is no room
    const std::optional<ImportJob> job = parse_request(request, input.view());
    if (!job) return false;
    const std::vector<std::byte> reply = reply_to(import, *job);
    if (!write_all(output_fd, reply)) ::_exit(kRefusedMemory);  // too much output would raise SIGXFSZ
    done.digest = request.digest;
    done.output_bytes = reply.size();
  }
  return send_message(socket, &done, sizeof done);
}

/// Reads files until the server has no more for this process.
int run_worker(int socket, const SandboxLimits& limits, const SyscallFilter& filter,
               const ImportFunction& import) {
  const SandboxReport report = enter_worker_sandbox(limits, filter);
  WorkerHello hello;
  hello.seccomp = report.seccomp ? 1 : 0;
  hello.seccomp_errno = report.seccomp_errno;
  if (!send_message(socket, &hello, sizeof hello)) return kNoServer;
  for (;;) {
    ImportRequest request;
    const Received received = receive_message(socket, &request, sizeof request);
    if (!received.whole) return kDone;
    const Descriptor input(received.descriptors[0]), output(received.descriptors[1]);
    if (!answer(socket, request, input.get(), output.get(), import)) return kBadRequest;
  }
}

/// Like fork(), but the child's parent is the server. glibc has no function for this. A raw call does not update glibc's own
/// records (the thread id), but that matters only to programs with several threads.
long fork_a_sibling() { return ::syscall(SYS_clone, CLONE_PARENT, 0, 0, 0, 0); }

}  // namespace

Expected<Mesh> import_job(const ImportJob& job) {
  return import_mesh(job.mesh, job.format, job.limits, job.files);
}

int run_zygote(int control, SandboxLimits limits, const ImportFunction& import) {
  std::set_new_handler(no_memory);
  std::set_terminate(ended);
  make_room();
  warm_up(import);
  // Free memory in the zygote's heap would be copied page by page when a fork writes to it.
  ::malloc_trim(0);
  make_room();
  const SyscallFilter filter;
  ZygoteHello hello;
  hello.address_space = address_space();
  // The limit is for the import. The program and its libraries (some hundred MiB of address space) must not count.
  if (limits.memory_bytes > 0) limits.memory_bytes += hello.address_space;
  hello.landlock = static_cast<std::uint32_t>(enter_zygote_sandbox());
  if (!send_message(control, &hello, sizeof hello)) return kNoServer;
  for (;;) {
    ForkRequest request;
    const Received received = receive_message(control, &request, sizeof request);
    if (!received.whole) return kDone;
    Descriptor socket(received.descriptors[0]);
    const Descriptor unasked(received.descriptors[1]);
    const long pid = fork_a_sibling();
    if (pid == 0) {
      // Replaces the zygote's connection to the server, so that no file can ever send anything on it.
      if (::dup2(socket.get(), control) < 0) return kNoServer;
      socket.reset();
      return run_worker(control, limits, filter, import);
    }
    ForkDone done;
    done.pid = static_cast<std::int32_t>(pid);
    done.error = pid < 0 ? errno : 0;
    if (!send_message(control, &done, sizeof done)) return kNoServer;
  }
}

int import_worker_main(int argc, char** argv, const ImportFunction& import) {
  SandboxLimits limits;
  const auto number = [&](int k, std::uint64_t& value) {
    const std::string_view text = argc == 3 ? argv[k] : "";
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size();
  };
  int type = 0;
  socklen_t size = sizeof type;
  if (!number(1, limits.memory_bytes) || !number(2, limits.cpu_seconds) ||
      ::getsockopt(kWorkerSocket, SOL_SOCKET, SO_TYPE, &type, &size) != 0 || type != SOCK_SEQPACKET) {
    std::fprintf(stderr, "%s works only when fracture-server starts it and passes it a socket.\n",
                 argc > 0 ? argv[0] : "fracture-import");
    return kNoServer;
  }
  try {
    const int code = run_zygote(kWorkerSocket, limits, import);
    ::_exit(code);  // skips destructors: nothing must be saved, and leak checks cannot run in the sandbox
  } catch (const std::bad_alloc&) {
    end_without_memory();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "fracture-import: %s\n", e.what());
    ::_exit(kNoSandbox);
  }
}

}  // namespace fracture
