// Reports how fast the server is: the requests of a collision, cached results compared with nginx, the cold
// start, and a Redis that hangs. Everything runs on 127.0.0.1, with limits on count and time.
//
//   bench_server [--collision MEMBERS [--requests N]] [FILE]
//
// FILE is the mesh; default: Suzanne_248.blend of assimp-testmodels. --collision measures only the requests
// of a collision, with these members in the request, e.g. '"sites": 50, "material": "stone"'.
// FRACTURE_TEST_SERVER names another build of the server to measure.
//
// Both ends run on this machine. On a machine that also does other work the results are upper bounds; the
// report says how busy it was.
#include <poll.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "common/digest/digest.hpp"
#include "tests/bench/server/game_client.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/server/support/temporary_folder.hpp"

namespace {

using fracture::sha256;
using fracture::bench::GameClient;
using fracture::test::ask;
using fracture::test::RawClient;
using fracture::test::Reply;
using fracture::test::ServeProcess;
using fracture::test::TemporaryFolder;
using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double percentile(std::vector<double> values, double p) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(p * static_cast<double>(values.size() - 1))];
}

void check(bool good, const std::string& what) {
  if (!good) throw std::runtime_error(what);  // no exit(), because servers must be stopped
}

/// A server whose log is read and discarded, so that writing the log has its normal cost.
struct Server {
  explicit Server(std::vector<std::string> flags = {}) : process(std::move(flags)) {
    reader = std::thread([this] {
      while (!process.error_line().empty()) {
      }
    });
  }
  ~Server() {
    process.signal(SIGTERM);
    reader.join();
    process.wait();
  }
  ServeProcess process;
  std::thread reader;
};

/// Milliseconds from the moment a thread takes up the request until its result exists, from Server-Timing.
double computed(std::string_view head) {
  const std::size_t begin = head.find("\r\nServer-Timing: "), at = head.find("work;dur=", begin);
  check(begin != std::string_view::npos && at != std::string_view::npos, "an answer without Server-Timing");
  return std::atof(std::string(head.substr(at + 9, 16)).c_str());
}

std::string request(const std::string& method, const std::string& target, const std::string& body = "") {
  std::string text = method + " " + target + " HTTP/1.1\r\nHost: bench\r\n";
  if (!body.empty())
    text += "Content-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) + "\r\n";
  return text + "\r\n" + body;
}

Reply converse(RawClient& client, const std::string& text) {
  check(client.send(text), "the server closed the connection");
  auto reply = client.receive();
  check(reply.has_value(), "no answer");
  return *reply;
}

struct MeshFile {
  std::string format, bytes;  ///< the format as the file extension names it
};

std::string store(std::uint16_t port, const MeshFile& mesh) {
  const Reply stored = ask(port, "POST", "/meshes?format=" + mesh.format, "", mesh.bytes);
  check(stored.status == 201, "POST /meshes: " + stored.body);
  return stored.header("location");
}

constexpr const char* kFiftySites = R"("sites": 50)";

std::string fracture_request(const std::string& mesh, int seed, const std::string& members = kFiftySites) {
  return request("POST", mesh + "/fracture", "{" + members + R"(, "seed": )" + std::to_string(seed) + "}");
}

void collision(const MeshFile& mesh, const std::string& members, int requests) {
  Server server({"--all-formats"});
  const std::string path = store(server.process.port, mesh);
  GameClient client(server.process.port);
  constexpr int kWarm = 20;
  std::vector<double> whole, overhead, compute, transfer;
  std::size_t bytes = 0;
  for (int seed = 0; seed < kWarm + requests; ++seed) {
    const std::string text = fracture_request(path, seed, members);
    const Clock::time_point start = Clock::now();
    const GameClient::Answer reply = client.ask(text);
    const double took = milliseconds_since(start);
    check(reply.status == 200 && reply.body.substr(0, 4) == "glTF",
          "a fracture failed: " + std::string(reply.body.substr(0, 300)));
    if (seed < kWarm) continue;
    whole.push_back(took);
    compute.push_back(computed(reply.head));
    overhead.push_back(took - compute.back());
    transfer.push_back(milliseconds_since(reply.first_byte));
    bytes += reply.body.size() / static_cast<std::size_t>(requests);
  }
  std::printf("collision-time path: stored mesh, %s, a new seed each, %d requests, %zu KB an answer\n",
              members.c_str(), requests, bytes / 1000);
  std::printf("  whole answer   p50 %7.3f ms   p99 %7.3f ms   (bar: p99 16 ms)\n", percentile(whole, .5),
              percentile(whole, .99));
  std::printf("  computing      p50 %7.3f ms   p99 %7.3f ms\n", percentile(compute, .5),
              percentile(compute, .99));
  // The cost of transferring such an answer: the last request again, answered from the cache.
  std::vector<double> carried;
  for (int i = 0; i < requests; ++i) {
    const std::string text = fracture_request(path, kWarm + requests - 1, members);
    const Clock::time_point start = Clock::now();
    client.ask(text);
    carried.push_back(milliseconds_since(start));
  }
  std::printf("  cached         p50 %7.3f ms   p99 %7.3f ms   (the same answer without computing)\n",
              percentile(carried, .5), percentile(carried, .99));
  std::printf("  from the first byte to the last p50 %.3f ms\n", percentile(transfer, .5));
  std::printf("  the rest       p50 %7.3f ms   p99 %7.3f ms   (bar: p50 0.3 ms)\n", percentile(overhead, .5),
              percentile(overhead, .99));
}

/// Requests per second over keep-alive connections. Each client sends the next request as soon as it gets an
/// answer.
double rate(std::uint16_t port, const std::string& target, std::size_t expected,
            std::chrono::milliseconds time) {
  constexpr int kConnections = 4;
  std::vector<std::thread> threads;
  std::atomic<long> answered{0};
  std::atomic<bool> wrong{false};
  const Clock::time_point end = Clock::now() + time, start = Clock::now();
  for (int c = 0; c < kConnections; ++c)
    threads.emplace_back([&] {
      try {
        GameClient client(port);
        const std::string text = request("GET", target);
        for (; Clock::now() < end && !wrong; ++answered)
          if (client.ask(text).body.size() != expected) wrong = true;
      } catch (const std::exception&) {
        wrong = true;
      }
    });
  for (std::thread& thread : threads) thread.join();
  check(!wrong, "a wrong answer from port " + std::to_string(port));
  return static_cast<double>(answered) / (milliseconds_since(start) / 1000);
}

/// nginx with one worker (the server has one io thread), serving a folder.
class Nginx {
 public:
  Nginx(const std::string& folder, std::uint16_t port, bool log) {
    ::chmod(folder.c_str(), 0755);
    std::ofstream(folder + "/nginx.conf")
        << "daemon off; worker_processes 1; pid " << folder << "/pid; error_log " << folder << "/error;\n"
        << "events { worker_connections 64; }\nhttp { access_log " << (log ? folder + "/access" : "off")
        << "; sendfile on; tcp_nopush on; keepalive_requests 1000000; open_file_cache max=10;\n"
        << "client_body_temp_path " << folder << "/b; proxy_temp_path " << folder << "/p; fastcgi_temp_path "
        << folder << "/f; uwsgi_temp_path " << folder << "/u; scgi_temp_path " << folder << "/s;\n"
        << "server { listen 127.0.0.1:" << port << "; root " << folder << "; } }\n";
    std::vector<std::string> arguments = {"nginx", "-c", folder + "/nginx.conf", "-e", folder + "/error"};
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
    running = ::posix_spawnp(&pid_, "nginx", &actions, nullptr, argv.data(), environ) == 0;
    posix_spawn_file_actions_destroy(&actions);
    for (int i = 0; running && i < 200; ++i) {
      try {
        RawClient probe(port);
        return;
      } catch (const std::runtime_error&) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
    }
    running = false;
  }
  ~Nginx() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGTERM);
    ::waitpid(pid_, nullptr, 0);
  }
  bool running = false;

 private:
  pid_t pid_ = 0;
};

/// Returns a port that is free at this moment.
std::uint16_t free_port() {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ::bind(fd, reinterpret_cast<sockaddr*>(&address), size);
  ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  ::close(fd);
  return ntohs(address.sin_port);
}

void cached(const MeshFile& mesh) {
  constexpr int kRounds = 5;
  constexpr std::chrono::milliseconds kTime{700};
  Server server({"--all-formats"});
  const std::string path = store(server.process.port, mesh);
  RawClient client(server.process.port);
  const Reply made = converse(client, fracture_request(path, 1));
  const std::string location = made.header("content-location");
  TemporaryFolder folder;
  std::ofstream(folder.path + "/file.glb", std::ios::binary) << made.body;
  const std::uint16_t port = free_port();
  for (const bool log : {true, false}) {
    Nginx nginx(folder.path, port, log);
    if (!nginx.running) {
      std::printf("cached result: nginx is not here, nothing to compare with\n");
      return;
    }
    double ours = 0, theirs = 0;  // the best of each, in turn: other work on the machine affects both
    for (int round = 0; round < kRounds; ++round) {
      ours = std::max(ours, rate(server.process.port, location, made.body.size(), kTime));
      theirs = std::max(theirs, rate(port, "/file.glb", made.body.size(), kTime));
    }
    std::printf(
        "cached result of %zu KB, 4 connections, best of %d: %.0f/s; nginx (one worker, %s) %.0f/s: %.0f %%"
        "   (bar: 60 %%)\n",
        made.body.size() / 1000, kRounds, ours, log ? "with its log" : "without a log", theirs,
        100 * ours / theirs);
  }
}

void cold_start() {
  constexpr int kRounds = 10;
  std::vector<double> times;
  for (int round = 0; round < kRounds; ++round) {
    const Clock::time_point start = Clock::now();
    Server server;
    check(ask(server.process.admin_port, "GET", "/readyz").status == 200, "not ready");
    times.push_back(milliseconds_since(start));
  }
  std::printf("cold start to ready: p50 %.0f ms, worst of %d %.0f ms   (bar: 300 ms)\n",
              percentile(times, .5), kRounds, percentile(times, 1));
}

/// A listener that accepts and says nothing, like a Redis that is stopped or cut off.
void hanging_redis(const MeshFile& mesh) {
  const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ::bind(listener, reinterpret_cast<sockaddr*>(&address), size);
  ::listen(listener, 64);
  ::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size);
  double worst = 0;
  {
    Server server({"--all-formats", "--redis", "127.0.0.1:" + std::to_string(ntohs(address.sin_port))});
    const std::string path = store(server.process.port, mesh);
    GameClient client(server.process.port);
    for (int seed = 0; seed < 200; ++seed) {
      const Clock::time_point start = Clock::now();
      const GameClient::Answer reply = client.ask(fracture_request(path, seed));
      check(reply.status == 200, "an error with a hanging Redis: " + std::string(reply.body.substr(0, 300)));
      worst = std::max(worst, milliseconds_since(start) - computed(reply.head));
    }
  }
  ::close(listener);
  std::printf(
      "a Redis that hangs: 200 requests, all answered, none more than %.1f ms slower than its computation   "
      "(bar: 60 ms)\n",
      worst);
}

int run(int argc, char** argv) {
  ::signal(SIGPIPE, SIG_IGN);
  std::filesystem::path file = "/usr/share/assimp/models/BLEND/Suzanne_248.blend";
  std::string members;
  int requests = 400;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--collision" && i + 1 < argc)
      members = argv[++i];
    else if (argument == "--requests" && i + 1 < argc)
      requests = std::max(1, std::atoi(argv[++i]));
    else
      file = argv[i];
  }
  std::ifstream stream(file, std::ios::binary);
  std::string format = file.extension().string();
  std::transform(format.begin(), format.end(), format.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  const MeshFile mesh{format.empty() ? format : format.substr(1),
                      {std::istreambuf_iterator<char>(stream), {}}};
  check(!mesh.bytes.empty(), "cannot read " + file.string());
  double load[1] = {0};
  ::getloadavg(load, 1);
  std::printf("%u cores, load average %.2f before the start; mesh %s\n", std::thread::hardware_concurrency(),
              load[0], file.c_str());
  collision(mesh, members.empty() ? kFiftySites : members, requests);
  if (!members.empty()) return 0;
  cached(mesh);
  cold_start();
  hanging_redis(mesh);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "bench_server: %s\n", e.what());
    return 1;
  }
}
