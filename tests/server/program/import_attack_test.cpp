// Harmful bodies and dying workers, over HTTP against the real program. The status is right, the same process
// goes on, no memory is kept, no file is read, and no other client is affected.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <sstream>
#include <thread>

#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/full_tests.hpp"

namespace fracture::test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kTetrahedron =
    "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

std::string contents_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(ImportIsolation, OnlyTheImportProcessContainsTheLibrariesThatReadFiles) {
  const std::filesystem::path server = server_program();
  const std::string serving = contents_of(server),
                    reading = contents_of(server.parent_path() / "fracture-import");
  for (const char* library : {"libassimp.so", "libdraco.so", "libmeshoptimizer.so", "libstb.so"}) {
    EXPECT_THAT(reading, HasSubstr(library));
    EXPECT_EQ(serving.find(library), std::string::npos) << library;
  }
}

TEST(ImportIsolation, WithoutThatProgramACommandSaysWhatIsMissing) {
  const TemporaryFolder folder;
  const std::string alone = folder.path + "/fracture-server", mesh = folder.path + "/t.off";
  std::filesystem::copy_file(server_program(), alone);
  std::ofstream(mesh) << kTetrahedron;
  for (const auto& [arguments, expected] :
       {std::pair{"bake " + mesh + " -o " + folder.path + "/t.glb", 1}, {"inspect " + mesh, 1}}) {
    FILE* const output = ::popen((alone + " " + arguments + " 2>&1").c_str(), "r");
    ASSERT_TRUE(output);
    char text[4096];
    const std::string said(text, std::fread(text, 1, sizeof text, output));
    const int status = ::pclose(output);
    EXPECT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), expected) << arguments;
    EXPECT_THAT(said, HasSubstr("fracture-import")) << arguments;
  }
}

TEST(BakeOfAFifo, EndsWhenItIsInterrupted) {
  const TemporaryFolder folder;
  const std::string fifo = folder.path + "/mesh.obj";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  FILE* const output = ::popen(("timeout --kill-after=10 --signal=INT 1 " + server_program() + " bake " +
                                fifo + " -o " + folder.path + "/t.glb 2>&1")
                                   .c_str(),
                               "r");
  ASSERT_TRUE(output);
  const int status = ::pclose(output);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 124) << "interrupted, not killed";
}

/// A server on free ports whose log is read while it runs, because a full pipe would stop it.
class Server : public ServeProcess {
 public:
  explicit Server(std::vector<std::string> flags = {})
      : ServeProcess(std::move(flags)), reader_([this] {
          while (!error_line().empty()) {
          }
        }) {}
  ~Server() {
    signal(SIGKILL);
    reader_.join();
  }
  std::vector<pid_t> children() const {
    std::vector<pid_t> pids;
    for (const auto& task : std::filesystem::directory_iterator("/proc/" + std::to_string(pid()) + "/task")) {
      std::ifstream list(task.path() / "children");
      std::copy(std::istream_iterator<pid_t>(list), {}, std::back_inserter(pids));
    }
    return pids;
  }
  /// The processes that read files. All are in the session that the zygote leads.
  std::vector<pid_t> workers() const {
    std::vector<pid_t> pids = children();
    std::erase_if(pids, [](pid_t pid) { return ::getsid(pid) == pid; });
    return pids;
  }
  /// The line of /metrics that begins with `name`; empty if there is none.
  std::string metric(const std::string& name) const {
    const std::string text = ask(admin_port, "GET", "/metrics").body;
    const std::size_t at = text.find("\n" + name);
    return at == std::string::npos ? "" : text.substr(at + 1, text.find('\n', at + 1) - at - 1);
  }
  /// Resident memory of the server itself, in MiB.
  double memory() const {
    std::ifstream status("/proc/" + std::to_string(pid()) + "/status");
    for (std::string line; std::getline(status, line);)
      if (line.rfind("VmRSS:", 0) == 0) return std::atof(line.c_str() + 6) / 1024;
    return 0;
  }

 private:
  std::thread reader_;
};

Reply post(const Server& server, const std::string& format, const std::string& body,
           const std::string& headers = "") {
  return ask(server.port, "POST", "/fracture?sites=5&physics=none&format=" + format,
             "Content-Type: application/octet-stream\r\nAccept: application/json\r\n" + headers, body);
}

std::string ply_declaring(const std::string& vertices) {
  return "ply\nformat binary_little_endian 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int "
         "vertex_indices\nend_header\n";
}

std::string gltf_with(const std::string& buffer, const std::string& count = "3") {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":)"
         R"([{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":)" +
         count + R"(}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[)" + buffer + "]}";
}

std::string gzip(const std::string& text) {
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, 16 + MAX_WBITS, 9, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

TEST(ImportIsolation, AClientThatLeavesEndsTheProcessThatReadsItsFile) {
  Server server;
  for (const pid_t worker : server.workers()) ::kill(worker, SIGSTOP);  // The stopped worker reads forever.
  {
    RawClient client(server.port);
    client.send("POST /fracture?format=off HTTP/1.1\r\nHost: a\r\nContent-Length: " +
                std::to_string(kTetrahedron.size()) + "\r\n\r\n" + kTetrahedron);
    require_eventually(kPatience, "the file to be read", [&] {
      return server.metric("fracture_import_workers_busy") == "fracture_import_workers_busy 1";
    });
  }
  for (const char* const expected : {"fracture_import_workers_busy 0", "fracture_flights 0",
                                     "fracture_memory_reserved_bytes{part=\"working\"} 0",
                                     "fracture_imports_total{outcome=\"interrupted\"} 1"}) {
    const std::string line = expected, name = line.substr(0, line.rfind(' '));
    EXPECT_TRUE(eventually(kPatience, line, [&] { return server.metric(name) == line; }));
  }
  EXPECT_EQ(post(server, "off", kTetrahedron).status, 200);
}

TEST(ImportAttack, KillerBodiesGetTheirStatusAndLeaveNothingBehind) {
  Server server({"--all-formats"});
  EXPECT_EQ(post(server, "off", kTetrahedron).status, 200);
  [[maybe_unused]] const double before = server.memory();

  struct Killer {
    const char* what;
    std::string format, body;
    int status;
    const char* problem;
  };
  const std::string bomb = gzip(std::string(300u << 20, ' '));
  const std::vector<Killer> killers = {
      {"ten million vertices", "ply", ply_declaring("10000000"), 422, "malformed-mesh"},
      {"a hundred million vertices", "ply", ply_declaring("100000000"), 422, "malformed-mesh"},
      {"400 KB of [", "gltf", std::string(400'000, '['), 422, "malformed-mesh"},
      {"an accessor of 2^31", "gltf",
       gltf_with(R"({"byteLength":36,"uri":"data:;base64,AAAA"})", "2147483648"), 422, "malformed-mesh"},
      {"a file of the machine", "gltf", gltf_with(R"({"byteLength":36,"uri":"/etc/passwd"})"), 422,
       "external-resource"},
      {"a file with its scheme", "gltf", gltf_with(R"({"byteLength":36,"uri":"file:///etc/passwd"})"), 422,
       "external-resource"},
      {"a file above", "gltf", gltf_with(R"({"byteLength":36,"uri":"../../../../etc/passwd"})"), 422,
       "external-resource"},
      {"a gzip bomb", "blend", bomb, 413, "too-large"},
      {"deep XML", "x3d",
       "<X3D>" +
           [] {
             std::string deep;
             for (int k = 0; k < 100'000; ++k) deep += "<Group>";
             return deep;
           }(),
       422, "malformed-mesh"},
      {"a library of the machine", "obj",
       "mtllib /etc/passwd\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\n"
       "f 1 2 4\nf 1 4 3\nf 2 3 4\n",
       200, ""},
      {"an object of the machine", "lws", "LWSC\n3\nLoadObjectLayer 1 /etc/passwd\nEndPlugin\n", 422, ""},
  };
  for (const Killer& killer : killers) {
    const Reply reply = post(server, killer.format, killer.body);
    EXPECT_EQ(reply.status, killer.status) << killer.what << ": " << reply.body.substr(0, 500);
    if (*killer.problem != 0) {
      EXPECT_EQ(reply.problem(), killer.problem) << killer.what << ": " << reply.body;
    }
    EXPECT_THAT(reply.body, Not(HasSubstr("root:"))) << killer.what;
    ASSERT_TRUE(server.alive()) << killer.what;
  }
  EXPECT_EQ(post(server, "off", kTetrahedron).status, 200);
#ifndef FRACTURE_SANITIZED  // The sanitizer's quarantine keeps freed memory.
  EXPECT_LT(server.memory() - before, 32) << "MiB of growth";
#endif
}

/// A grid of n x n quads as OBJ: an import that takes a while.
std::string large_obj(int n) {
  std::string obj;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) obj += "v " + std::to_string(x) + " " + std::to_string(y) + " 0\n";
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int a = y * (n + 1) + x + 1;
      obj += "f " + std::to_string(a) + " " + std::to_string(a + 1) + " " + std::to_string(a + n + 2) + " " +
             std::to_string(a + n + 1) + "\n";
    }
  return obj;
}

/// Waits for a worker that has been reading for a while. Returns 0 if there is none. Workers that were forked
/// meanwhile only wait, and have used hardly any processor time.
pid_t busy_worker(const Server& server) {
  const auto ticks = [](pid_t pid) {
    std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
    std::string text{std::istreambuf_iterator<char>(stat), {}}, field;
    const std::size_t name_end = text.rfind(')');
    std::istringstream fields(name_end == std::string::npos ? "" : text.substr(name_end + 2));
    for (int k = 3; k < 14; ++k) fields >> field;  // proc(5): utime is the 14th, stime the 15th
    long user = 0, system = 0;
    fields >> user >> system;
    return user + system;
  };
  pid_t at_work = 0;
  EXPECT_TRUE(eventually(kPatience, "a worker to be at work", [&] {
    for (const pid_t pid : server.workers())
      if (ticks(pid) >= 3) at_work = pid;
    return at_work != 0;
  }));
  return at_work;
}

TEST(ImportAttack, AWorkerKilledInMidImportCostsItsRequestAloneA422) {
  Server server({"--import-workers", "2"});
  const std::string large = large_obj(sized(500, 900));
  for (const int signal : {SIGKILL, SIGSEGV}) {
    EXPECT_EQ(post(server, "off", kTetrahedron).status, 200);
    auto doomed = std::async(std::launch::async, [&] { return post(server, "obj", large); });
    pid_t victim = busy_worker(server);
    ASSERT_NE(victim, 0);
    ::kill(victim, signal);
    if (signal == SIGKILL) {  // a kill from outside: the file is read once more
      EXPECT_TRUE(eventually(kPatience, "the first reader to be gone", [&] {
        const std::vector<pid_t> left = server.workers();
        return std::count(left.begin(), left.end(), victim) == 0;
      }));
      victim = busy_worker(server);
      ASSERT_NE(victim, 0);
      ::kill(victim, signal);
    }
    const Reply reply = doomed.get();
    const bool outside = signal == SIGKILL;
    EXPECT_EQ(reply.status, outside ? 503 : 422) << reply.body.substr(0, 300);
    EXPECT_EQ(reply.problem(), outside ? "overloaded" : "importer-crashed");
    EXPECT_EQ(reply.header("retry-after").empty(), !outside);
    EXPECT_THAT(reply.json().value("detail", ""), HasSubstr("signal " + std::to_string(signal)));
    EXPECT_EQ(post(server, "obj", kTetrahedron.substr(4)).status, 422);
    EXPECT_EQ(post(server, "off", kTetrahedron + "# " + std::to_string(signal)).status, 200);
    const std::vector<pid_t> now = server.workers();
    EXPECT_EQ(std::count(now.begin(), now.end(), victim), 0) << "reaped";
  }
  EXPECT_TRUE(server.alive());
}

TEST(ImportAttack, AMeshThatKilledItsReaderIsRefusedAtOnceAndOnlyIt) {
  Server server({"--import-workers", "1"});
  const std::string large = large_obj(sized(500, 900));
  auto doomed = std::async(std::launch::async, [&] { return post(server, "obj", large); });
  const pid_t victim = busy_worker(server);
  ASSERT_NE(victim, 0);
  ::kill(victim, SIGSEGV);
  const Reply first = doomed.get();
  ASSERT_EQ(first.status, 422) << first.body.substr(0, 300);
  const std::string remembered = "fracture_imports_total{outcome=\"remembered\"} ";
  EXPECT_EQ(server.metric(remembered), remembered + "0");
  const Reply again = post(server, "obj", large);
  EXPECT_EQ(again.status, 422);
  EXPECT_EQ(again.problem(), "importer-crashed");
  EXPECT_EQ(again.json().value("detail", ""), first.json().value("detail", "?"));
  EXPECT_EQ(server.metric(remembered), remembered + "1");
  EXPECT_EQ(post(server, "obj", large + "#").status, 422) << "another file: read, and open as it is";
  EXPECT_EQ(server.metric(remembered), remembered + "1");
}

TEST(ImportAttack, TheSandboxIsShownAndCanBeRequired) {
  Server server({"--require-sandbox", "yes"});
  EXPECT_EQ(post(server, "off", kTetrahedron).status, 200);
  EXPECT_EQ(server.metric("fracture_import_sandbox{layer=\"seccomp\"}"),
            "fracture_import_sandbox{layer=\"seccomp\"} 1");
  EXPECT_THAT(server.metric("fracture_import_sandbox{layer=\"landlock\"}"),
              ::testing::MatchesRegex(".* [01]"));
}

TEST(ImportAttack, AFileOverTheMemoryOfAWorkerIs422) {
#ifdef FRACTURE_SANITIZED
  GTEST_SKIP() << "the sanitizers reserve terabytes: no limit of the address space";
#else
  // Enough for small files, too little for this mesh.
  Server server({"--import-memory", std::to_string(16u << 20)});
  EXPECT_EQ(post(server, "off", kTetrahedron).status, 200);
  const Reply reply = post(server, "obj", large_obj(500));
  EXPECT_EQ(reply.status, 422) << reply.body.substr(0, 300);
  EXPECT_EQ(reply.problem(), "importer-limit");
  EXPECT_EQ(post(server, "off", kTetrahedron + "#").status, 200);
#endif
}

TEST(ImportAttack, TheWorkersEndWithTheServer) {
  std::vector<pid_t> workers;
  {
    Server server;
    EXPECT_EQ(post(server, "off", kTetrahedron).status, 200);
    workers = server.children();
    ASSERT_GE(workers.size(), 2u) << "the zygote too";
  }  // The server is killed with SIGKILL.
  for (const pid_t pid : workers) {
    EXPECT_TRUE(eventually(kPatience, "the end of process " + std::to_string(pid), [&] {
      if (::kill(pid, 0) != 0) return true;
      std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
      const std::string text{std::istreambuf_iterator<char>(stat), {}};
      return text.find(") Z ") != std::string::npos;  // a zombie that its new parent has not reaped yet
    }));
  }
}

}  // namespace
}  // namespace fracture::test
