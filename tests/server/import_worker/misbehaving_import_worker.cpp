// The import worker with an import that does what the file says, for tests of the server's side and of the
// sandbox. A file that is not a command is imported.
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include "server/import_worker/worker.hpp"

namespace fracture {
namespace {

tl::unexpected<Error> told(long result, int error) {
  return fail(ErrorCode::kMalformedMesh,
              result >= 0 ? "succeeded with " + std::to_string(result) : "errno " + std::to_string(error));
}

/// Tries a call that the sandbox should refuse, and reports the result.
tl::unexpected<Error> attempt(const std::string& what) {
  errno = 0;
  long result = -1;
  if (what == "open") result = ::open("/etc/passwd", O_RDONLY);
  if (what == "create") result = ::open("/tmp/fracture-import-was-here", O_WRONLY | O_CREAT, 0600);
  if (what == "socket") result = ::socket(AF_INET, SOCK_STREAM, 0);
  if (what == "fork") result = ::fork();
  if (what == "exec") result = ::execl("/bin/true", "true", nullptr);
  if (what == "kill") result = ::kill(::getppid(), 0);
  if (what == "code")
    result = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) !=
                     MAP_FAILED
                 ? 0
                 : -1;
  if (result == 0 && what == "fork") ::_exit(0);
  return told(result, errno);
}

/// Writes to each page in a way that the compiler cannot optimize out.
void touch(std::vector<char>& block) {
  for (std::size_t k = 0; k < block.size(); k += 4096) const_cast<volatile char&>(block[k]) = 1;
}

Mesh triangle(std::uint32_t last) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, last}};
  mesh.material = {kNoIndex};
  mesh.node = {0};
  mesh.node_names = {"a"};
  return mesh;
}

Expected<Mesh> obey(const ImportJob& job) {
  std::string text(reinterpret_cast<const char*>(job.mesh.data()),
                   std::min<std::size_t>(job.mesh.size(), 64));
  if (text.rfind("! ", 0) != 0) return import_job(job);
  text.erase(0, 2);
  if (text == "hang") {
    int ends[2];
    char byte = 0;
    if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends) == 0) (void)!::read(ends[0], &byte, 1);
    for (;;) ::sched_yield();  // The sandbox allows no wait without a descriptor.
  }
  if (text == "spin")
    for (std::atomic<unsigned> k{0};;) ++k;
  if (text == "null") *static_cast<volatile int*>(nullptr) = 1;
  if (text == "exit") ::_exit(7);
  if (text == "memory") {
    std::vector<std::vector<char>> blocks;
    for (;;) touch(blocks.emplace_back(16u << 20));
  }
  static bool somebody_was_here = false;
  if (text == "stay") {  // as if a file had taken over its reader
    somebody_was_here = true;
    return triangle(2);
  }
  if (text.rfind("look", 0) == 0)
    return fail(ErrorCode::kMalformedMesh, somebody_was_here ? "somebody was here" : "nobody was here");
  if (text == "answer for another") {
    ImportDone done;
    done.digest.fill('0');
    (void)send_message(kWorkerSocket, &done, sizeof done);
    for (;;) ::sched_yield();
  }
  if (text == "unfold") {
    Mesh mesh = triangle(2);
    mesh.copyright.assign(1100u << 20, 'x');
    return mesh;
  }
  if (text == "lie") return triangle(3);
  if (text == "lie about code") return fail(ErrorCode::kInternal, "it is the server's fault");
  if (text.rfind("try ", 0) == 0) return attempt(text.substr(4));
  return fail(ErrorCode::kMalformedMesh, "an unknown command");
}

}  // namespace
}  // namespace fracture

int main(int argc, char** argv) { return fracture::import_worker_main(argc, argv, fracture::obey); }
