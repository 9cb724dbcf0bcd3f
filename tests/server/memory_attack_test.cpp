// The real program in little memory, under small requests that unfold: what is resident stays within what it
// may have, and others are served.
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <functional>
#include <iterator>
#include <thread>

#include "tests/server/exposition.hpp"
#include "tests/server/gzip.hpp"
#include "tests/server/raw_client.hpp"
#include "tests/server/server_process.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

const std::string kCube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
const std::string kForm = "Content-Type: multipart/form-data; boundary=B\r\nContent-Encoding: gzip\r\n";
const std::string kGltf = "Content-Type: model/gltf+json\r\n";

std::string many(const std::string& item, std::size_t count) {
  std::string text;
  text.reserve(item.size() * count);
  for (std::size_t k = 0; k < count; ++k) text += item;
  return text;
}

std::string form_of(const std::string& params) {
  return "--B\r\nContent-Disposition: form-data; name=mesh; filename=a.obj\r\n\r\n" + kCube +
         "\r\n--B\r\nContent-Disposition: form-data; name=params\r\n\r\n" + params + "\r\n--B--\r\n";
}

/// A tetrahedron, with something more in the document.
std::string gltf_with(const std::string& more, const std::string& material = "{}", int unique = 0) {
  return R"({"asset":{"version":"2.0","copyright":")" + std::to_string(unique) +
         R"("},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0)" + more +
         R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],"materials":[)" +
         material +
         R"(],"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},)"
         R"({"bufferView":1,"componentType":5121,"count":12,"type":"SCALAR"},)"
         R"({"componentType":5126,"count":900000,"type":"VEC3"}],)"
         R"("bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}],)"
         R"("buffers":[{"byteLength":60,"uri":"data:application/octet-stream;base64,)"
         R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAIBAAEDAAMCAQID"}]})";
}

std::uint64_t resident_of(const std::string& pid) {
  std::ifstream statm("/proc/" + pid + "/statm");
  std::uint64_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// Of a process and its children, at its peak, looked at every few milliseconds.
class Watch {
 public:
  explicit Watch(pid_t pid)
      : thread_([this, root = std::to_string(pid)] {
          while (!stop_) {
            std::uint64_t sum = resident_of(root);
            for (const auto& task : std::filesystem::directory_iterator("/proc/" + root + "/task")) {
              std::ifstream children(task.path() / "children");
              for (std::string child; children >> child;) sum += resident_of(child);
            }
            peak_ = std::max<std::uint64_t>(peak_, sum);
            std::this_thread::sleep_for(std::chrono::milliseconds(5));  // pause: a sampler
          }
        }) {}
  ~Watch() {
    stop_ = true;
    thread_.join();
  }
  std::uint64_t peak() const { return peak_; }

 private:
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> peak_{0};
  std::thread thread_;
};

struct Attack {
  const char* name;
  /// Sends one request of many; the n-th.
  std::function<int(std::uint16_t port, int n)> send;
};

const Attack kAttacks[] = {
    {"RepeatedMembers",
     [](std::uint16_t port, int) {
       static const std::string body =
           gzip(form_of("{" + many("\"a\":0,", 80'000) + "\"a\":[0" + many(",0", 250'000) + "]}"));
       return ask(port, "POST", "/fracture", kForm, body).status;
     }},
    {"MuchAroundAForm",
     [](std::uint16_t port, int n) {
       static const std::string body = gzip(std::string(60u << 20, 'x') + "\r\n" + form_of("{}"));
       return ask(port, "POST", "/meshes?weld_tolerance=1e-" + std::to_string(4 + n % 8), kForm, body).status;
     }},
    {"LargeExtras",
     [](std::uint16_t port, int n) {
       const std::string material = "{\"extras\":[0" + many(",0", 4'000'000) + "]}";
       return ask(port, "POST", "/meshes", kGltf + "Content-Encoding: gzip\r\n",
                  gzip(gltf_with("", material, n)))
           .status;
     }},
    {"Instances",
     [](std::uint16_t port, int n) {
       return ask(port, "POST", "/fracture?sites=3", kGltf,
                  gltf_with(R"(,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":2}}})",
                            "{}", n))
           .status;
     }},
};

struct MemoryAttack : testing::TestWithParam<Attack> {};

TEST_P(MemoryAttack, WhatIsResidentStaysWithinTheBudgetAndOthersAreServed) {
  ServeProcess server({"--memory", "768MiB", "--import-workers", "2"});
  std::uint64_t peak = 0;
  int served = 0;
  {
    const Watch watch(server.pid());
    std::vector<std::thread> attackers;
    std::atomic<int> done{0};
    for (int thread = 0; thread < 4; ++thread)
      attackers.emplace_back([&, thread] {
        for (int k = 0; k < 4; ++k) {
          try {
            GetParam().send(server.port, 4 * thread + k);
          } catch (const std::runtime_error&) {  // cut off
          }
        }
        ++done;
      });
    for (int seed = 0; done < 4 || (served < 5 && seed < 500); ++seed) {  // 503s in between are allowed
      const Reply reply = ask(server.port, "POST", "/fracture?sites=4&seed=" + std::to_string(seed),
                              "Content-Type: model/obj\r\n", kCube);
      EXPECT_TRUE(reply.status == 200 || reply.status == 503) << reply.body;
      served += reply.status == 200;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));  // pause: a client beside the attack
    }
    for (std::thread& attacker : attackers) attacker.join();
    peak = watch.peak();
  }
  const Exposition m = parse_exposition(ask(server.admin_port, "GET", "/metrics").body);
  const double limit = m["fracture_memory_limit_bytes"];
  EXPECT_EQ(limit, 768u << 20);
  EXPECT_LE(1.3 * m.sum("fracture_memory_budget_bytes") + m["fracture_memory_base_bytes"], limit);
#ifndef FRACTURE_SANITIZED
  EXPECT_LE(static_cast<double>(peak), limit) << (peak >> 20) << " MiB";
  // At rest it holds no more than it says, beside what every server holds.
  const auto at_rest = [&] {
    const Exposition now = parse_exposition(ask(server.admin_port, "GET", "/metrics").body);
    return now.sum("fracture_memory_resident_bytes") <=
           1.3 * now.sum("fracture_memory_reserved_bytes") + now["fracture_memory_base_bytes"];
  };
  EXPECT_TRUE(eventually(std::chrono::seconds(30), "what was held to be given back", at_rest))
      << ask(server.admin_port, "GET", "/metrics").body;
#endif
  EXPECT_GE(served, 5);
  std::printf("%s: peak %llu MiB of %.0f MiB\n", GetParam().name, static_cast<unsigned long long>(peak >> 20),
              limit / (1 << 20));
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

INSTANTIATE_TEST_SUITE_P(Rows, MemoryAttack, testing::ValuesIn(kAttacks),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace fracture::test
