#include "tests/server/support/test_server.hpp"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

namespace fracture::test {

TestServerOptions::TestServerOptions() {
  limits.max_body = 8u << 20;
  limits.max_connections_per_address = 512;
  server.allowed_hosts = {"*"};  // the clients of tests use any Host
}

TestServer::TestServer(const TestServerOptions& options)
    : control(options.control ? options.control : std::make_shared<FakeControl>()),
      service(options.service, std::make_unique<FakeEngine>(control)),
      pool(options.threads, options.max_queue),
      dispatcher(service, pool, options.dispatcher),
      api(dispatcher, options.limits, options.store, options.jobs),
      server(options.server, (api.show_page(options.page), api.offer(options.samples), api)) {
  spdlog::set_level(spdlog::level::off);
}

TestServer::~TestServer() {
  EXPECT_EQ(server.bulk_turns(), 0u)
      << "an io thread hashed, inflated, parsed or sorted more than it may in one turn";
}

Reply TestServer::get(const std::string& target, const std::string& fields) {
  return ask(port(), "GET", target, fields);
}
Reply TestServer::post(const std::string& target, const std::string& body, const std::string& fields) {
  return ask(port(), "POST", target, fields, body);
}
Reply TestServer::put(const std::string& target, const std::string& body, const std::string& fields) {
  return ask(port(), "PUT", target, fields, body);
}
Reply TestServer::post_json(const std::string& target, const std::string& body, const std::string& fields) {
  return ask(port(), "POST", target, "Content-Type: application/json\r\n" + fields, body);
}

}  // namespace fracture::test
