// Real assets, posted to the real program with every format enabled. The same process answers each of them,
// with fragments or with a 4xx that names its reason. The answers are listed in the build folder. With
// FRACTURE_TEST_FULL=1 every site count and every file is tested; otherwise a sample.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <thread>

#include "common/import/sibling_files.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/mesh_files.hpp"

namespace fracture::test {
namespace {

namespace fs = std::filesystem;

bool full_run() {
  const char* set = std::getenv("FRACTURE_TEST_FULL");
  return set != nullptr && std::string(set) == "1";
}

std::string read_whole(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// A server whose log is read while it runs, because a full pipe would stop it. The last line remains
/// available afterwards.
class Server {
 public:
  Server()
      : process_({"--all-formats", "--deadline", "25", "--log-level", "info", "--mesh-cache", "1",
                  "--diagram-cache", "1", "--result-cache", "1"}),
        reader_([this] {
          for (std::string line; !(line = process_.error_line()).empty();) last_line = line;
        }) {}
  ~Server() {
    process_.signal(SIGKILL);
    reader_.join();
  }
  bool alive() { return process_.alive(); }
  std::uint16_t port() const { return process_.port; }
  /// Resident memory in MiB.
  double memory() const {
    std::ifstream status("/proc/" + std::to_string(process_.pid()) + "/status");
    for (std::string line; std::getline(status, line);)
      if (line.rfind("VmRSS:", 0) == 0) return std::atof(line.c_str() + 6) / 1024;
    return 0;
  }
  std::string last_line;  ///< complete once the process has ended

 private:
  ServeProcess process_;
  std::thread reader_;
};

/// Posts the file and the files that it refers to as a form. Returns the report, or status 0 if there is no
/// reply.
Reply post(Server& server, const std::string& path, const std::string& query) {
  const std::string bytes = read_whole(path);
  std::string extension = fs::path(path).extension().string();
  extension = extension.empty() ? "none" : extension.substr(1);
  std::vector<SiblingFile> siblings;
  if (const auto format = format_from_extension(extension))
    siblings = read_sibling_files(path, std::as_bytes(std::span(bytes)), *format);
  const std::string boundary = "fracture-assets-test-boundary";
  const auto part = [&](const std::string& name, const std::string& filename, const std::string& body) {
    return "--" + boundary + "\r\nContent-Disposition: form-data; name=" + name + "; filename=\"" + filename +
           "\"\r\n\r\n" + body + "\r\n";
  };
  std::string form = part("mesh", "mesh." + extension, bytes);
  for (const SiblingFile& file : siblings) form += part("file", file.name, file.bytes);
  form += "--" + boundary + "--\r\n";
  try {
    return ask(server.port(), "POST", "/fracture?" + query,
               "Accept: application/json\r\nContent-Type: multipart/form-data; boundary=" + boundary + "\r\n",
               form);
  } catch (const std::exception&) {
    return {};
  }
}

/// A single line: the status with the main numbers, or the reason.
std::string summary_of(const Reply& reply) {
  if (reply.status != 200)
    return std::to_string(reply.status) + " " + reply.problem() + ": " + reply.json().value("detail", "");
  const auto certificate = reply.json().at("certificate");
  return "200 " + certificate.at("fragments").dump() + " fragments, volume " +
         certificate.at("volume_out").dump();
}

/// The reason without the parts that belong to the file: quoted names and numbers.
std::string reason_of(const Reply& reply) {
  std::string reason;
  bool quoted = false;
  for (const char c : reply.json().value("detail", "")) {
    quoted ^= c == '"' || c == '\'';
    const bool digit = (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+';
    if (quoted) continue;
    if (!digit)
      reason += c;
    else if (reason.empty() || reason.back() != '#')
      reason += '#';
  }
  return std::to_string(reply.status) + " " + reply.problem() + ": " + reason.substr(0, 110);
}

TEST(Assets, EveryDevelopmentMeshIsFracturedOrRefusedWithItsReason) {
  const std::vector<MeshFile> files = test_meshes();
  if (files.empty()) GTEST_SKIP() << "FRACTURE_TEST_MESHES is absent";
  std::ofstream list(fs::path(FRACTURE_TEST_OUTPUT) / "dev_meshes.txt");
  Server server;
  const std::vector<std::string> counts =
      full_run() ? std::vector<std::string>{"5", "50", "300"} : std::vector<std::string>{"5"};
  for (const MeshFile& file : files)
    for (const std::string& sites : counts) {
      const Reply reply = post(server, file.path, "physics=none&sites=" + sites);
      list << file.name << ' ' << sites << ' ' << summary_of(reply) << std::endl;
      ASSERT_TRUE(server.alive()) << file.name;
      if (reply.status == 422) {
        EXPECT_EQ(reply.problem(), "mesh-not-closed") << file.name << ": " << reply.body;
        EXPECT_EQ(file.name, "soup.stl") << reply.body;
        continue;
      }
      ASSERT_EQ(reply.status, 200) << file.name << ' ' << sites << ": " << reply.body;
      const auto certificate = reply.json().at("certificate");
      EXPECT_EQ(certificate.at("open_edges"), 0) << file.name;
      EXPECT_LT(certificate.at("relative_error").get<double>(), 1e-9) << file.name;
    }
}

TEST(Assets, EveryModelOfAssimpGetsAnAnswerFromTheSameProcess) {
  const fs::path folder = "/usr/share/assimp/models";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "assimp-testmodels is not installed";
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  if (!full_run())  // every 20th
    for (std::size_t k = 0; k < files.size(); ++k) std::swap(files[k / 20], files[k]), k += 19;
  if (!full_run()) files.resize(files.size() / 20);

  std::ofstream list(fs::path(FRACTURE_TEST_OUTPUT) / "assimp_models.txt");
  auto server = std::make_unique<Server>();
  const double before = server->memory();
  std::map<std::string, std::size_t> tally, reasons;
  std::size_t died = 0;
  for (const fs::path& file : files) {
    const Reply reply = post(*server, file.string(), "sites=10");
    const std::string name = fs::relative(file, folder).generic_string();
    if (reply.status == 0) {
      // A live server keeps its connections. If there is no answer, wait a moment to see whether the server
      // died.
      const bool dead{eventually(std::chrono::seconds(1), "its end", [&] { return !server->alive(); })};
      ++died;
      ++tally[dead ? "died" : "no answer"];
      list << name << (dead ? " DIED" : " NO ANSWER") << std::endl;
      ADD_FAILURE() << name << (dead ? ": the server died" : ": no answer");
      server = std::make_unique<Server>();
      continue;
    }
    ++tally[std::to_string(reply.status) + " " + reply.problem()];
    list << name << ' ' << summary_of(reply) << std::endl;
    EXPECT_TRUE(reply.status == 200 || (reply.status >= 400 && reply.status < 500))
        << name << ": " << reply.body;
    if (reply.status != 200) {
      ++reasons[reason_of(reply)];
      EXPECT_GE(reply.json().value("detail", "").size(), 20u) << name << ": " << reply.body;
    }
  }
  for (const auto& [what, count] : tally) list << "total " << count << ' ' << what << '\n';
  for (const auto& [reason, count] : reasons) list << "reason " << count << ' ' << reason << '\n';
  EXPECT_EQ(died, 0u);
  EXPECT_TRUE(server->alive());
  // Freed memory returns to the system once the server is idle.
  constexpr double kGrowth = 64;
  EXPECT_TRUE(
      eventually(kPatience, "freed memory to go back", [&] { return server->memory() < before + kGrowth; }));
  const double after = server->memory();
  list << "total memory before " << before << " MiB, after " << after << " MiB\n";
  EXPECT_LT(after - before, kGrowth) << "MiB";
}

}  // namespace
}  // namespace fracture::test
