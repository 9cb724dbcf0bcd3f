// A whole server in the test's own process, on free ports, with the fake engine and with limits that a test
// can reach.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "server/http/server.hpp"
#include "tests/server/support/fake_engine.hpp"
#include "tests/server/support/raw_client.hpp"

namespace fracture::test {

struct TestServerOptions {
  http::ServerConfig server{.address = "127.0.0.1", .port = 0, .admin_port = 0, .io_threads = 2};
  http::HttpLimits limits;
  ServiceConfig service;
  DispatcherConfig dispatcher;
  StoreConfig store;
  JobsConfig jobs;
  std::shared_ptr<FakeControl> control;  ///< hooks for the engine from the start on; null: a new one
  int threads = 2;
  std::size_t max_queue = 64;
  bool page = true;  ///< serve the page to browsers, if the build contains it
  page::Samples samples;

  TestServerOptions();
};

class TestServer {
 public:
  explicit TestServer(const TestServerOptions& options = {});
  ~TestServer();

  std::uint16_t port() const { return server.port(); }
  Reply get(const std::string& target, const std::string& fields = "");
  Reply post(const std::string& target, const std::string& body = "a mesh",
             const std::string& fields = "Content-Type: model/gltf-binary\r\n");
  Reply put(const std::string& target, const std::string& body,
            const std::string& fields = "Content-Type: model/gltf-binary\r\n");
  /// Posts a JSON body.
  Reply post_json(const std::string& target, const std::string& body, const std::string& fields = "");

  std::shared_ptr<FakeControl> control;
  FractureService service;
  WorkerPool pool;
  Dispatcher dispatcher;
  http::Api api;
  http::HttpServer server;
};

}  // namespace fracture::test
