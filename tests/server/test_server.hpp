// A whole server in the test's own process, on free ports, with the fake engine and limits that a test can
// reach.
#pragma once

#include <spdlog/spdlog.h>

#include <memory>
#include <string>

#include "server/http/server.hpp"
#include "tests/server/fake_engine.hpp"
#include "tests/server/raw_client.hpp"

namespace fracture::test {

struct TestServerOptions {
  http::ServerConfig server{.address = "127.0.0.1", .port = 0, .admin_port = 0, .io_threads = 2};
  http::HttpLimits limits;
  ServiceConfig service;
  DispatcherConfig dispatcher;
  StoreConfig store;
  JobsConfig jobs;
  std::shared_ptr<FakeControl> control;  ///< of the engine, for what a server does by itself; null: a new one
  int threads = 2;
  std::size_t max_queue = 64;

  TestServerOptions() {
    limits.max_body = 8u << 20;
    limits.max_connections_per_address = 512;
    server.allowed_hosts = {"*"};  // these clients call it as they like
  }
};

class TestServer {
 public:
  explicit TestServer(const TestServerOptions& options = {})
      : control(options.control ? options.control : std::make_shared<FakeControl>()),
        service(options.service, std::make_unique<FakeEngine>(control)),
        pool(options.threads, options.max_queue),
        dispatcher(service, pool, options.dispatcher),
        api(dispatcher, options.limits, options.store, options.jobs),
        server(options.server, api) {
    spdlog::set_level(spdlog::level::off);
  }

  std::uint16_t port() const { return server.port(); }
  Reply get(const std::string& target, const std::string& fields = "") {
    return ask(port(), "GET", target, fields);
  }
  Reply post(const std::string& target, const std::string& body = "a mesh",
             const std::string& fields = "Content-Type: model/gltf-binary\r\n") {
    return ask(port(), "POST", target, fields, body);
  }

  Reply put(const std::string& target, const std::string& body,
            const std::string& fields = "Content-Type: model/gltf-binary\r\n") {
    return ask(port(), "PUT", target, fields, body);
  }
  /// As JSON.
  Reply post_json(const std::string& target, const std::string& body, const std::string& fields = "") {
    return ask(port(), "POST", target, "Content-Type: application/json\r\n" + fields, body);
  }

  std::shared_ptr<FakeControl> control;
  FractureService service;
  WorkerPool pool;
  Dispatcher dispatcher;
  http::Api api;
  http::HttpServer server;
};

}  // namespace fracture::test
