// Access to the server: bearer tokens, and requests from pages of other origins.
#include <gtest/gtest.h>

#include "tests/server/support/requests.hpp"
#include "tests/server/support/test_server.hpp"

namespace fracture::test {
namespace {

TestServerOptions with_tokens() {
  TestServerOptions options;
  options.server.tokens =
      *tenants::TokenFile::parse("ana 0123456789abcdef\nbob readonly-token-1234 read-only\n");
  return options;
}

TEST(Tokens, OnlyAKnownTokenOpensThePublicListener) {
  TestServer server(with_tokens());
  const std::string good = "Authorization: Bearer 0123456789abcdef\r\n";
  EXPECT_EQ(server.get("/version", good).status, 200);
  EXPECT_EQ(server.get("/version", "authorization: bearer 0123456789abcdef\r\n").status, 200);
  EXPECT_EQ(server.post("/fracture", "mesh", kObj + good).status, 200);
  const std::string wrong[] = {"",
                               "Authorization: Bearer 0123456789abcdeF\r\n",
                               "Authorization: Bearer 0123456789abcde\r\n",
                               "Authorization: Bearer 0123456789abcdef0\r\n",
                               "Authorization: Bearer \r\n",
                               "Authorization: Basic 0123456789abcdef\r\n",
                               "Authorization: 0123456789abcdef\r\n",
                               good + good,
                               good + "Authorization: Bearer x\r\n"};
  for (const std::string& fields : wrong) {
    const Reply reply = server.post("/fracture", "mesh", kObj + fields);
    EXPECT_EQ(reply.status, 401) << fields;
    EXPECT_EQ(reply.problem(), "unauthorized") << fields;
    EXPECT_EQ(reply.header("www-authenticate").rfind("Bearer realm=", 0), 0u) << fields;
    EXPECT_EQ(server.get("/nothing", fields).status, 401) << "who is not known learns no paths";
  }
  EXPECT_EQ(server.control->imports, 1);
}

TEST(Tokens, AReadOnlyTokenMayGetAndHeadButNotPost) {
  TestServer server(with_tokens());
  const std::string token = "Authorization: Bearer readonly-token-1234\r\n";
  EXPECT_EQ(server.get("/limits", token).status, 200);
  EXPECT_EQ(ask(server.port(), "HEAD", "/limits", token).status, 200);
  const Reply reply = server.post("/fracture", "mesh", kObj + token);
  EXPECT_EQ(reply.status, 403);
  EXPECT_EQ(reply.problem(), "forbidden");
  EXPECT_NE(reply.header("www-authenticate").find("insufficient_scope"), std::string::npos);
}

TEST(Tokens, ARefusalComesBeforeTheBodyIsRead) {
  TestServer server(with_tokens());
  RawClient client(server.port());
  client.send("POST /fracture HTTP/1.1\r\nHost: a\r\n" + kObj +
              "Content-Length: 1000\r\nExpect: 100-continue\r\n\r\n");
  EXPECT_EQ(client.receive()->status, 401);
}

TEST(Tokens, TheAdminListenerAsksForNone) {
  TestServer server(with_tokens());
  EXPECT_EQ(ask(server.server.admin_port(), "GET", "/readyz").status, 200);
}

TEST(Cors, IsOffByDefault) {
  TestServer server;
  const std::string origin = "Origin: https://example.org\r\n";
  EXPECT_EQ(server.get("/version", origin).header("access-control-allow-origin"), "");
  EXPECT_EQ(
      ask(server.port(), "OPTIONS", "/fracture", origin + "Access-Control-Request-Method: POST\r\n").status,
      403);
}

TEST(Cors, AnAllowedOriginMayAskAndReadEveryAnswer) {
  TestServerOptions options;
  options.server.cors_origins = {"https://example.org", "http://localhost:5173"};
  TestServer server(options);
  const std::string origin = "Origin: https://example.org\r\n";
  const Reply preflight =
      ask(server.port(), "OPTIONS", "/fracture",
          origin + "Access-Control-Request-Method: POST\r\nAccess-Control-Request-Headers: content-type\r\n");
  EXPECT_EQ(preflight.status, 204);
  EXPECT_EQ(preflight.header("access-control-allow-origin"), "https://example.org");
  EXPECT_NE(preflight.header("access-control-allow-methods").find("POST"), std::string::npos);
  EXPECT_NE(preflight.header("access-control-allow-headers").find("Content-Type"), std::string::npos);
  EXPECT_EQ(preflight.headers.count("content-length"), 0u) << "RFC 9110, section 8.6";

  for (const Reply& reply : {server.post("/fracture", "mesh", kObj + origin), server.get("/nothing", origin),
                             server.post("/fracture?sites=0", "mesh", kObj + origin)}) {
    EXPECT_EQ(reply.header("access-control-allow-origin"), "https://example.org") << reply.status;
    EXPECT_NE(reply.header("access-control-expose-headers").find("ETag"), std::string::npos) << reply.status;
  }
  const Reply other = server.get("/version", "Origin: https://evil.example\r\n");
  EXPECT_EQ(other.status, 403) << "no token is asked for";
  EXPECT_EQ(other.header("access-control-allow-origin"), "");
  EXPECT_EQ(other.header("vary"), "Origin") << "or a shared cache hands the answer to the wrong page";
  const Reply refused = ask(server.port(), "OPTIONS", "/fracture",
                            "Origin: https://evil.example\r\nAccess-Control-Request-Method: POST\r\n");
  EXPECT_EQ(refused.header("access-control-allow-methods"), "");
}

TEST(Cors, APreflightNeedsNoTokenAndKeepsTheConnection) {
  TestServerOptions options = with_tokens();
  options.server.cors_origins = {"*"};
  TestServer server(options);
  RawClient client(server.port());
  client.send(
      "OPTIONS /fracture HTTP/1.1\r\nHost: a\r\nOrigin: null\r\nAccess-Control-Request-Method: POST\r\n\r\n");
  const auto preflight = client.receive();
  ASSERT_TRUE(preflight);
  EXPECT_EQ(preflight->status, 204);
  EXPECT_EQ(preflight->header("access-control-allow-origin"), "*");
  client.send(
      "GET /version HTTP/1.1\r\nHost: a\r\nOrigin: null\r\nAuthorization: Bearer 0123456789abcdef\r\n\r\n");
  EXPECT_EQ(client.receive()->status, 200);
  client.send("GET /version HTTP/1.1\r\nHost: a\r\nOrigin: null\r\n\r\n");
  const auto refused = client.receive();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 401);
  EXPECT_EQ(refused->header("access-control-allow-origin"), "*") << "the page can read why";
}

int status_for(TestServer& server, const std::string& fields, std::uint16_t port = 0,
               const std::string& target = "/version") {
  RawClient client(port != 0 ? port : server.port());
  client.send("GET " + target + " HTTP/1.1\r\n" + fields + "\r\n");
  return client.receive().value().status;
}

TEST(Sites, ANameThatIsNotOursIsRefusedWhereNoTokenIsAskedFor) {
  TestServerOptions options;
  options.server.allowed_hosts = {"farm.example"};
  TestServer server(options);
  for (const char* host :
       {"127.0.0.1", "127.0.0.1:8080", "[::1]:8080", "localhost", "LocalHost:8080", "a.localhost",
        "192.168.3.4:8080", "farm.example", "FARM.example:80", "farm.example.", ""})
    EXPECT_EQ(status_for(server, std::string("Host: ") + host + "\r\n"), 200) << host;
  for (const char* host :
       {"evil.example", "evil.example:8080", "localhost.evil.example", "notlocalhost",
        "127.0.0.1.evil.example", "1.2.3", "[::1", "[::1]evil.example", "[::1].evil.example",
        "[::1]:80.evil.example", "[[::1]]", "[]", "localhost:evil.example", "127.0.0.1:80:evil.example",
        "farm.example:80.evil.example", "evil.example:80.localhost", ":80", "localhost:", "localhost:123456"})
    for (const std::uint16_t port : {server.port(), server.server.admin_port()}) {
      const std::string target = port == server.port() ? "/version" : "/metrics";
      EXPECT_EQ(status_for(server, std::string("Host: ") + host + "\r\n", port, target), 403) << host;
    }
  RawClient client(server.port());
  client.send("GET /version HTTP/1.1\r\nHost: evil.example\r\n\r\n");
  const auto reply = client.receive();
  EXPECT_EQ(reply->problem(), "foreign-host");
  EXPECT_NE(reply->body.find("--allow-host"), std::string::npos);
}

TEST(Sites, APageOfAnotherSiteCannotPost) {
  TestServerOptions options;
  options.server.allowed_hosts = {"farm.example"};
  options.server.cors_origins = {"https://game.example"};
  TestServer server(options);
  const std::string host = "Host: 127.0.0.1\r\n";
  for (const char* origin :
       {"https://evil.example", "null", "http://127.0.0.1.evil.example", "http://6.6.6.6",
        "https://game.example.evil.example", "localhost", "http://[::1]evil.example",
        "http://localhost:evil.example", "http://localhost:80.evil.example",
        "http://localhost:80, https://evil.example", "http://evil.example:80.localhost"})
    EXPECT_EQ(status_for(server, host + "Origin: " + origin + "\r\n"), 403) << origin;
  for (const char* origin : {"http://127.0.0.1:8080", "http://localhost:5173", "http://[::1]",
                             "https://game.example", "https://farm.example"})
    EXPECT_EQ(status_for(server, host + "Origin: " + origin + "\r\n"), 200) << origin;
  EXPECT_EQ(status_for(server, "Host: 10.0.0.7:80\r\nOrigin: http://10.0.0.7\r\n"), 200) << "its own page";

  const std::string form =
      "--B\r\nContent-Disposition: form-data; name=mesh; filename=a.obj\r\n\r\nv\r\n--B--\r\n";
  const Reply posted = server.post(
      "/fracture", form, "Content-Type: multipart/form-data; boundary=B\r\nOrigin: https://evil.example\r\n");
  EXPECT_EQ(posted.status, 403);
  EXPECT_EQ(server.control->imports, 0);
}

TEST(Sites, WhoHasATokenIsNotAskedWhereItComesFrom) {
  TestServerOptions options = with_tokens();
  options.server.allowed_hosts.clear();
  TestServer server(options);
  const std::string token = "Authorization: Bearer 0123456789abcdef\r\n";
  EXPECT_EQ(status_for(server, "Host: any.example\r\nOrigin: https://any.example\r\n" + token), 200);
  EXPECT_EQ(status_for(server, "Host: any.example\r\n", server.server.admin_port(), "/metrics"), 403)
      << "the admin listener asks for no token";
}

}  // namespace
}  // namespace fracture::test
