// The real program as a process of its own: real meshes over HTTP, bad input, bake against serve, signals.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/raw_client.hpp"

extern char** environ;

namespace fracture::test {
namespace {

namespace fs = std::filesystem;

class Process {
 public:
  explicit Process(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), FRACTURE_SERVER_PROGRAM);
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe");
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], 2);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    const int error = posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    if (error != 0) throw std::runtime_error("cannot start " + arguments[0]);
    errors_ = ::fdopen(ends[0], "r");
  }
  ~Process() {
    if (!ended_) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
    std::fclose(errors_);
  }
  std::string error_line() {
    char line[1000];
    return std::fgets(line, sizeof line, errors_) ? line : "";
  }
  void signal(int number) { ::kill(pid_, number); }
  /// The exit code, or 1000 + the signal that killed it.
  int wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    ended_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  }
  bool alive() { return ::kill(pid_, 0) == 0 && ::waitpid(pid_, nullptr, WNOHANG) == 0; }

 private:
  pid_t pid_ = 0;
  FILE* errors_ = nullptr;
  bool ended_ = false;
};

/// `fracture-server serve` on free ports, which it names in its first log line.
class ServeProcess : public Process {
 public:
  explicit ServeProcess(std::vector<std::string> flags = {}) : Process(with_ports(std::move(flags))) {
    const std::string line = error_line();
    const std::size_t colon = line.rfind(':', line.find(" (admin port ")), admin = line.find("admin port ");
    if (colon == std::string::npos || admin == std::string::npos)
      throw std::runtime_error("unexpected: " + line);
    port = static_cast<std::uint16_t>(std::atoi(line.c_str() + colon + 1));
    admin_port = static_cast<std::uint16_t>(std::atoi(line.c_str() + admin + 11));
  }
  std::uint16_t port = 0, admin_port = 0;

 private:
  static std::vector<std::string> with_ports(std::vector<std::string> flags) {
    std::vector<std::string> all = {"serve", "--port", "0", "--admin-port", "0", "--threads", "2"};
    if (std::find(flags.begin(), flags.end(), "--drain-delay") == flags.end())
      flags.insert(flags.end(), {"--drain-delay", "0"});
    all.insert(all.end(), flags.begin(), flags.end());
    return all;
  }
};

/// An axis-aligned unit cube, closed, as OBJ text.
const std::string kCube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
const std::string kObj = "Content-Type: model/obj\r\n";

struct EndToEnd : testing::Test {
  fs::path folder = fs::temp_directory_path() / ("fracture_end_to_end_" + std::to_string(::getpid()));
  void SetUp() override { fs::create_directories(folder); }
  void TearDown() override { fs::remove_all(folder); }

  std::string write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return (folder / name).string();
  }
  static std::string read(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

TEST_F(EndToEnd, ACubeComesBackAsFragmentsThatAddUpToIt) {
  ServeProcess server;
  const Reply reply =
      ask(server.port, "POST", "/fracture?sites=20&seed=5", kObj + "Accept: application/json\r\n", kCube);
  ASSERT_EQ(reply.status, 200) << reply.body;
  const auto certificate = reply.json().at("certificate");
  EXPECT_EQ(certificate.at("open_edges"), 0);
  EXPECT_GE(certificate.at("fragments"), 20);
  EXPECT_DOUBLE_EQ(certificate.at("volume_in"), 1.0);
  EXPECT_NEAR(certificate.at("volume_out").get<double>(), 1.0, 1e-9);
  EXPECT_EQ(reply.json().at("parameters"),
            nlohmann::json::parse(R"({"dual":"circumcenter","seed":5,"sites":20})"));
}

TEST_F(EndToEnd, BakeAndServeGiveTheSameBytesForAnyNumberOfThreads) {
  const std::string mesh = write("cube.obj", kCube);
  std::string reference;
  for (const char* threads : {"1", "2", "5"}) {
    const std::string out = (folder / "out.glb").string();
    Process bake({"bake", mesh, "-o", out, "--sites", "200", "--seed", "9", "--threads", threads});
    ASSERT_EQ(bake.wait(), 0);
    if (reference.empty()) reference = read(out);
    EXPECT_EQ(read(out), reference) << threads << " threads";
  }
  EXPECT_EQ(reference.substr(0, 4), "glTF");
  ServeProcess server;
  EXPECT_EQ(ask(server.port, "POST", "/fracture?sites=200&seed=9", kObj, kCube).body, reference);
  EXPECT_TRUE(fs::exists(folder / "out.glb"));
  for (const auto& entry : fs::directory_iterator(folder))
    EXPECT_EQ(entry.path().string().find(".tmp"), std::string::npos);
}

TEST_F(EndToEnd, SimultaneousRequestsGetTheirOwnAnswers) {
  ServeProcess server;
  std::vector<std::string> alone, together(12);
  for (int i = 0; i < 12; ++i)
    alone.push_back(
        ask(ServeProcess().port, "POST", "/fracture?sites=30&seed=" + std::to_string(i), kObj, kCube).body);
  std::vector<std::thread> threads;
  for (int i = 0; i < 12; ++i)
    threads.emplace_back([&, i] {
      together[static_cast<std::size_t>(i)] =
          ask(server.port, "POST", "/fracture?sites=30&seed=" + std::to_string(i), kObj, kCube).body;
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(together, alone);
}

TEST_F(EndToEnd, BadInputGetsAStatusAndAProblemAPersonCanActOnAndTheProcessLives) {
  ServeProcess server({"--max-body", "100000"});
  const std::string glb = ask(server.port, "POST", "/fracture?sites=4", kObj, kCube).body;
  ASSERT_EQ(glb.substr(0, 4), "glTF");
  const std::string type_glb = "Content-Type: model/gltf-binary\r\n";
  std::string nan_stl(84 + 50, '\0');
  nan_stl[80] = 1;
  for (std::size_t at = 84; at < 84 + 48; at += 4) nan_stl.replace(at, 4, std::string("\x00\x00\xc0\x7f", 4));
  const struct {
    const char* what;
    std::string target, fields, body;
    int status;
    const char* problem;
  } cases[] = {
      {"empty body", "/fracture", type_glb, "", 400, "empty-body"},
      {"truncated GLB", "/fracture", type_glb, glb.substr(0, glb.size() / 2), 422, "malformed-mesh"},
      {"GLB of which only the header is left", "/fracture", type_glb, glb.substr(0, 12), 422,
       "malformed-mesh"},
      {"text file called .glb", "/fracture?format=glb", "", "This is not a mesh.\n", 422, "malformed-mesh"},
      {"NaN in an OBJ", "/fracture", kObj, "v nan 0 0\n" + kCube.substr(8), 422, ""},
      {"NaN in an STL", "/fracture?format=stl", "", nan_stl, 422, "not-finite"},
      {"sites=0", "/fracture?sites=0", kObj, kCube, 400, "bad-parameter"},
      {"sites=-5", "/fracture?sites=-5", kObj, kCube, 400, "bad-parameter"},
      {"sites=1e12", "/fracture?sites=1e12", kObj, kCube, 400, "bad-parameter"},
      {"unknown parameter", "/fracture?size=5", kObj, kCube, 400, "unknown-parameter"},
      {"unknown format", "/fracture?format=docx", "", kCube, 415, "unknown-format"},
      {"a format that is off", "/fracture?format=blend", "", "BLENDER", 415, "unknown-format"},
      {"body over the limit", "/fracture", kObj, std::string(100'001, ' '), 413, "body-too-large"},
      {"one open quad", "/fracture", kObj, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", 422,
       "mesh-not-closed"},
      {"an OBJ without faces", "/fracture", kObj, "v 0 0 0\nv 1 0 0\n", 422, ""},
      {"a glTF that names a local file", "/fracture", "Content-Type: model/gltf+json\r\n",
       R"({"asset":{"version":"2.0"},"buffers":[{"uri":"/etc/passwd","byteLength":100}]})", 422,
       "external-resource"},
  };
  for (const auto& c : cases) {
    const Reply reply = ask(server.port, "POST", c.target, c.fields, c.body);
    EXPECT_EQ(reply.status, c.status) << c.what << ": " << reply.body;
    EXPECT_EQ(reply.header("content-type"), "application/problem+json") << c.what;
    if (*c.problem) {
      EXPECT_EQ(reply.problem(), c.problem) << c.what << ": " << reply.body;
    }
    EXPECT_GE(reply.json().value("detail", "").size(), 20u) << c.what << ": " << reply.body;
    EXPECT_TRUE(server.alive()) << c.what;
  }
  EXPECT_EQ(ask(server.port, "POST", "/fracture?sites=4", kObj, kCube).body, glb)
      << "the same process, the same bytes";
}

TEST_F(EndToEnd, SigtermDrainsAndExitsWithZero) {
  ServeProcess server({"--drain-delay", "1"});
  EXPECT_EQ(ask(server.admin_port, "GET", "/readyz").status, 200);
  RawClient kept(server.port);
  kept.send("GET /version HTTP/1.1\r\nHost: a\r\n\r\n");
  ASSERT_TRUE(kept.receive());
  server.signal(SIGTERM);
  int status = 200;
  for (int i = 0; i < 50 && status == 200; ++i) status = ask(server.admin_port, "GET", "/readyz").status;
  EXPECT_EQ(status, 503);
  EXPECT_EQ(ask(server.port, "POST", "/fracture?sites=4", kObj, kCube).status, 200)
      << "within the drain delay";
  EXPECT_EQ(server.wait(), 0);
  EXPECT_EQ(kept.receive_all(), "");
}

TEST_F(EndToEnd, AWorkingRequestIsFinishedAfterSigint) {
  ServeProcess server;
  RawClient client(server.port);
  client.send("POST /fracture?sites=3000 HTTP/1.1\r\nHost: a\r\n" + kObj +
              "Content-Length: " + std::to_string(kCube.size()) + "\r\n\r\n" + kCube);
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  server.signal(SIGINT);
  // The header may or may not have been read when the signal came; a request that was read is answered.
  const auto reply = client.receive();
  if (reply) {
    EXPECT_EQ(reply->status, 200);
  }
  EXPECT_EQ(server.wait(), 0);
}

TEST_F(EndToEnd, ATakenPortIsSaidAndEndsWithOne) {
  ServeProcess server;
  Process second({"serve", "--port", std::to_string(server.port), "--admin-port", "0"});
  const std::string line = second.error_line();
  EXPECT_EQ(second.wait(), 1);
  EXPECT_NE(line.find(std::to_string(server.port)), std::string::npos) << line;
}

TEST_F(EndToEnd, BakeSaysWhatIsWrongAndLeavesNoFile) {
  const std::string quad = write("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  const std::string cube = write("cube.obj", kCube);
  const std::string out = (folder / "out.glb").string();
  const struct {
    std::vector<std::string> arguments;
    int code;
  } cases[] = {
      {{"bake", quad, "-o", out}, 3},
      {{"bake", cube, "-o", out, "--sites", "0"}, 3},
      {{"bake", cube, "-o", out, "--dual", "triangle"}, 3},
      {{"bake", cube, "-o", out, "--format", "glb"}, 3},
      {{"bake", (folder / "absent.obj").string(), "-o", out}, 1},
      {{"bake", cube, "-o", (folder / "no" / "such" / "folder.glb").string()}, 1},
      {{"bake", cube}, 2},
      {{"bake", cube, "-o", out, "--colour", "red"}, 2},
      {{"dance"}, 2},
  };
  for (const auto& c : cases) {
    Process bake(c.arguments);
    const std::string line = bake.error_line();
    EXPECT_EQ(bake.wait(), c.code) << line;
    EXPECT_FALSE(fs::exists(out));
  }
}

}  // namespace
}  // namespace fracture::test
