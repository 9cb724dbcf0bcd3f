// The page that browsers get at /, with and without a page in the build.
#include <gtest/gtest.h>

#include "server/page/page.hpp"
#include "server/page/samples.hpp"
#include "tests/server/support/gzip.hpp"
#include "tests/server/support/requests.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/server/support/test_server.hpp"

namespace fracture::test {
namespace {

/// The Accept header of Firefox and Chromium.
const std::string kBrowser =
    "Accept: text/html,application/xhtml+xml,application/xml;q=0.9,image/avif,image/webp,*/*;q=0.8\r\n";
const std::string kPacked = "Accept-Encoding: gzip, deflate, br, zstd\r\n";

std::string target_of(const page::File& file) {
  if (file.path == "index.html") return "/";
  return file.path == "docs.html" ? "/docs" : "/page/" + std::string(file.path);
}

TEST(Page, ProgramsGetJsonAndBrowsersHtml) {
  TestServer server;
  for (const std::string& accept :
       {std::string(), std::string("Accept: */*\r\n"), std::string("Accept: application/json\r\n"),
        std::string("Accept: application/json, text/html\r\n")})
    EXPECT_EQ(server.get("/", accept).json().at("name"), "fracture-server") << accept;
  const Reply html = server.get("/", kBrowser);
  EXPECT_EQ(html.status, 200);
  EXPECT_EQ(html.header("content-type"), "text/html; charset=utf-8");
  EXPECT_NE(html.header("vary").find("Accept"), std::string::npos);
  EXPECT_EQ(html.header("content-security-policy").rfind("default-src 'none'", 0), 0u);
  if (page::files().empty()) {
    EXPECT_NE(html.body.find("built without its page"), std::string::npos);
  }
}

TEST(Page, EveryFileComesAsItIsAndCompressedAndIsKnownByItsTag) {
  TestServer server;
  if (page::files().empty()) GTEST_SKIP() << "this server was built without its page";
  ASSERT_NE(page::find("index.html"), nullptr);
  ASSERT_NE(page::find("docs.html"), nullptr);
  for (const page::File& file : page::files()) {
    const std::string target = target_of(file);
    const Reply plain = server.get(target, kBrowser), packed = server.get(target, kBrowser + kPacked);
    ASSERT_EQ(plain.status, 200) << target;
    EXPECT_EQ(plain.body, gunzip(std::string(file.gzip.begin(), file.gzip.end()))) << target;
    EXPECT_EQ(plain.header("content-encoding"), "") << target;
    EXPECT_EQ(packed.header("content-encoding"), "gzip") << target;
    EXPECT_EQ(packed.body.size(), file.gzip.size()) << target;
    EXPECT_NE(packed.header("etag"), plain.header("etag")) << "each coding has its own";
    EXPECT_EQ(
        server
            .get(target, kBrowser + kPacked + "If-None-Match: " + std::string(packed.header("etag")) + "\r\n")
            .status,
        304);
    EXPECT_EQ(
        server.get(target, kBrowser + "If-None-Match: " + std::string(packed.header("etag")) + "\r\n").status,
        200);
    EXPECT_NE(plain.header("content-security-policy").find("frame-ancestors 'none'"), std::string::npos);
    const Reply head = ask(server.port(), "HEAD", target, kBrowser + kPacked);
    EXPECT_EQ(head.header("content-length"), std::to_string(file.gzip.size())) << target;
    const Reply plain_head = ask(server.port(), "HEAD", target, kBrowser);
    EXPECT_EQ(plain_head.header("content-length"), std::to_string(plain.body.size())) << target;
  }
  EXPECT_EQ(server.get("/page/none.js", kBrowser).problem(), "not-found");
  EXPECT_GE(server.get("/page/..%2Findex.html", kBrowser).status, 400) << "no segment leads out of the table";
}

TEST(Page, WhatItLoadsIsThere) {
  const page::File* const index = page::find("index.html");
  if (!index) GTEST_SKIP() << "this server was built without its page";
  const std::string html(index->plain.begin(), index->plain.end());
  std::size_t named = 0;
  for (std::size_t at = html.find("/page/"); at != std::string::npos;
       at = html.find("/page/", at + 1), ++named) {
    const std::string path = html.substr(at + 6, html.find_first_of("\"'", at) - at - 6);
    EXPECT_NE(page::find(path), nullptr) << path;
  }
  EXPECT_GE(named, 2u) << "a script and a style at least";
}

TEST(Page, NeedsNoTokenAndGivesNothingElseAway) {
  TestServerOptions options;
  options.server.tokens = *tenants::TokenFile::parse("ana 0123456789abcdef\n");
  TestServer server(options);
  EXPECT_EQ(server.get("/", kBrowser).status, 200);
  EXPECT_EQ(server.get("/").status, 401) << "JSON is for who is known";
  EXPECT_EQ(server.get("/limits", kBrowser).status, 401);
  const int there = page::files().empty() ? 404 : 200;
  EXPECT_EQ(server.get("/docs", kBrowser).status, there);
  EXPECT_EQ(server.get("/page/documents.json", "Accept: application/json\r\n").status, there);
  EXPECT_EQ(server.post("/", "x", kBrowser).status, 401);
}

TEST(Page, TurnedOffItOpensNothingToWhoHasNoToken) {
  TestServerOptions options;
  options.page = false;
  options.server.tokens = *tenants::TokenFile::parse("ana 0123456789abcdef\n");
  TestServer server(options);
  for (const char* target : {"/", "/docs", "/page/app.js"})
    EXPECT_EQ(server.get(target, kBrowser).status, 401) << target;
  EXPECT_EQ(server.get("/", kBrowser + "Authorization: Bearer 0123456789abcdef\r\n").status, 200);
}

TEST(Page, OffersTheMeshesThatItWasGiven) {
  TemporaryFolder folder;
  const std::string bytes = "v 0 0 0\n", mesh = folder.write("od\"d \xff.obj", bytes);
  auto samples = page::Samples::load({mesh});
  ASSERT_TRUE(samples);
  TestServerOptions options;
  options.samples = *samples;
  options.server.tokens = *tenants::TokenFile::parse("ana 0123456789abcdef\n");
  TestServer server(options);
  const nlohmann::json list = server.get("/page/samples.json", kBrowser).json();
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].at("name"), "od\"d \ufffd.obj");
  EXPECT_EQ(list[0].at("bytes"), bytes.size());
  const Reply sample = server.get("/page/" + list[0].at("file").get<std::string>(), kBrowser);
  EXPECT_EQ(sample.body, bytes);
  EXPECT_EQ(sample.header("content-type"), "application/octet-stream");
  EXPECT_EQ(server.get("/page/sample-1", kBrowser).problem(), "not-found");

  options.page = false;
  TestServer hidden(options);
  for (const char* target : {"/page/samples.json", "/page/sample-0"})
    EXPECT_EQ(hidden.get(target, kBrowser).status, 401) << target;
  TestServer without;
  EXPECT_EQ(without.get("/page/samples.json", kBrowser).json(), nlohmann::json::array());
}

TEST(Page, SamplesThatCannotBeHeldAreRefusedByName) {
  TemporaryFolder folder;
  const auto why = [](const std::vector<std::string>& paths) {
    const auto samples = page::Samples::load(paths);
    return samples ? std::string("taken") : samples.error().detail;
  };
  EXPECT_NE(why({folder / "none.glb"}).find("none.glb"), std::string::npos);
  EXPECT_NE(why({folder / ""}).find("is not a file"), std::string::npos);
  EXPECT_NE(why({"/dev/zero"}).find("is not a file"), std::string::npos);
  EXPECT_NE(why({folder.write("empty.glb", "")}).find("is empty"), std::string::npos);
  const std::string large = folder.write("large.glb", std::string(page::kMostSampleBytes / 2 + 1, 'x'));
  EXPECT_EQ(why({large}), "taken");
  EXPECT_NE(why({large, large}).find("16 MiB"), std::string::npos);
  EXPECT_NE(why(std::vector<std::string>(page::kMostSamples + 1, large)).find("17"), std::string::npos);
}

TEST(Page, CanBeTurnedOff) {
  TestServerOptions options;
  options.page = false;
  TestServer server(options);
  EXPECT_EQ(server.get("/", kBrowser).json().at("name"), "fracture-server");
  for (const char* target : {"/docs", "/page/app.js"})
    EXPECT_EQ(server.get(target, kBrowser).problem(), "not-found") << target;
}

}  // namespace
}  // namespace fracture::test
