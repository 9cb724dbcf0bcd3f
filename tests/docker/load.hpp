// Games in front of the farm. Each has one connection and asks for fractures of stored meshes without a
// pause. If a mesh is missing, it does what the interface says: it gets 404, sends PUT and asks again. Every
// other answer than the right one counts as a failure.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/digest/digest.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {

/// A different box for each number.
struct StoredMesh {
  explicit StoredMesh(int number) {
    const std::string x = std::to_string(1 + 0.001 * number);
    for (const char* corner : {"0 0 0", "X 0 0", "X 1 0", "0 1 0", "0 0 1", "X 0 1", "X 1 1", "0 1 1"})
      text += "v " + (corner[0] == 'X' ? x + (corner + 1) : std::string(corner)) + "\n";
    text += "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    path = "/meshes/sha256:" + sha256(text).hex();
  }
  std::string text, path;
};

/// One client. It reopens a connection that was closed between two answers.
class GameClient {
 public:
  explicit GameClient(std::uint16_t port) : port_(port) {}

  /// Throws std::runtime_error if no whole answer arrived.
  Reply ask(const std::string& method, const std::string& path, const std::string& type,
            const std::string& body) {
    const std::string request = method + " " + path +
                                " HTTP/1.1\r\nHost: localhost\r\nContent-Type: " + type +
                                "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
    // The connection was closed while it was idle: no answer begins.
    if (connection_) {
      connection_->send(request);
      if (!connection_->receive_until("HTTP/1.1", kPatience)) connection_.reset();
    }
    if (!connection_) {
      connection_.emplace(port_);
      connection_->send(request);
    }
    const std::optional<Reply> reply = connection_->receive(false, kPatience);
    if (!reply || reply->header("connection") == "close") connection_.reset();
    if (!reply) throw std::runtime_error("no whole answer to " + method + " " + path);
    return *reply;
  }
  /// Fractures a stored mesh, and puts it (again) if it is missing. Returns 404 if the mesh never stays.
  Reply fracture(const StoredMesh& mesh, int seed) {
    // Each further attempt means that its server went away between two requests.
    constexpr int kTries = 20;
    for (int tries = 1;; ++tries) {
      Reply reply = ask("POST", mesh.path + "/fracture", "application/json",
                        R"({"sites": 6, "seed": )" + std::to_string(seed) + "}");
      if (reply.status != 404 || tries == kTries) return reply;
      reply = ask("PUT", mesh.path, "model/obj", mesh.text);
      if (reply.status != 200 && reply.status != 201) return reply;
      ++puts;
    }
  }
  int puts = 0;

 private:
  const std::uint16_t port_;
  std::optional<RawClient> connection_;
};

/// Several clients at the same time, until the object is destroyed.
class Load {
 public:
  Load(std::uint16_t port, int clients, int meshes, int seeds) {
    for (int m = 0; m < meshes; ++m) meshes_.emplace_back(m);
    for (int c = 0; c < clients; ++c)
      clients_.emplace_back([this, port, c, seeds] {
        GameClient client(port);
        for (int i = 7919 * c; !stop_; ++i) play(client, i, seeds);
      });
  }
  ~Load() { stop(); }
  void stop() {
    stop_ = true;
    for (std::thread& client : clients_)
      if (client.joinable()) client.join();
  }
  /// Waits until this many more requests were answered, or returns earlier if one failed. Throws if neither
  /// happens.
  void wait_for(int more) const {
    const int end = answered + more;
    require_eventually(kPatience, std::to_string(more) + " more answers",
                       [&] { return answered >= end || failed != 0; });
  }
  std::string first_failure() const {
    const std::lock_guard lock(mutex_);
    return first_failure_;
  }

  std::atomic<int> answered{0}, failed{0}, from_caches{0}, puts{0};

 private:
  void play(GameClient& client, int i, int seeds) {
    const StoredMesh& mesh = meshes_[static_cast<std::size_t>(i) % meshes_.size()];
    const int seed = i / static_cast<int>(meshes_.size()) % seeds;
    try {
      const int puts_before = client.puts;
      const bool stored = i % 8 != 0;
      // Every eighth request carries its mesh, and gets the same bytes from any server.
      const Reply reply = stored ? client.fracture(mesh, seed)
                                 : client.ask("POST", "/fracture?sites=6&seed=" + std::to_string(seed),
                                              "model/obj", mesh.text);
      puts += client.puts - puts_before;
      if (reply.status != 200) return fail(std::to_string(reply.status) + " " + reply.body);
      for (const char* hit : {"redis; hit", "result; hit"})  // hits of the answer itself
        if (reply.header("cache-status").find(hit) != std::string::npos) ++from_caches;
      const Digest digest = sha256(reply.body);
      const std::lock_guard lock(mutex_);
      const auto [known, first] = digests_.emplace(mesh.path + " " + std::to_string(seed), digest);
      if (known->second != digest) first_failure_ = "other bytes for the same request";
      ++(known->second == digest ? answered : failed);
    } catch (const std::runtime_error& e) {
      fail(e.what());
    }
  }
  void fail(const std::string& what) {
    const std::lock_guard lock(mutex_);
    if (failed++ == 0) first_failure_ = what;
  }

  std::vector<StoredMesh> meshes_;
  std::vector<std::thread> clients_;
  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;
  std::map<std::string, Digest> digests_;
  std::string first_failure_;
};

}  // namespace fracture::test
