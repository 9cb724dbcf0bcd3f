// bake and answers that fail their certificate, from servers that send them anyway.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "common/digest/digest.hpp"
#include "common/pipeline/algorithm_version.hpp"
#include "tests/server/support/bake_folder.hpp"
#include "tests/server/support/bake_program.hpp"
#include "tests/server/support/relay.hpp"
#include "tests/server/support/server_process.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

/// A server whose answers are changed in transit.
class Tampered {
 public:
  explicit Tampered(std::function<std::string(std::string)> change) : change_(std::move(change)) {}
  std::string url() const { return "http://127.0.0.1:" + std::to_string(door_.port()); }

 private:
  ServeProcess server_;
  const std::function<std::string(std::string)> change_;
  FakeServer door_{[this](const FakeRequest& request) {
    FakeReply reply = pass_on(request, server_.port);
    reply.bytes = change_(std::move(reply.bytes));
    return reply;
  }};
};

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  if (const std::size_t at = text.find(what); at != std::string::npos) text.replace(at, what.size(), by);
  return text;
}

/// RFC 4648.
std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k) three = three << 8 | (at + k < bytes.size() ? bytes[at + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += at + k <= bytes.size() ? kDigits[three >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

/// The reply of a server that does not check its certificates.
std::string opened(std::string reply) {
  const std::size_t end = reply.find("\r\n\r\n");
  const std::size_t digest = reply.find("sha-256=:");
  if (reply.find("model/gltf-binary") > end || digest > end) return reply;
  std::string body = replaced(reply.substr(end + 4), "{\"open_edges\":0,", "{\"open_edges\":7,");
  const std::string true_digest = "sha-256=:" + base64(sha256(body).bytes) + ":";
  reply.replace(digest, true_digest.size(), true_digest);
  return reply.substr(0, end + 4) + body;
}

TEST_F(BakeProgram, AnAnswerThatDoesNotProveItselfIsNotWrittenForOneFileAndForMany) {
  const Tampered older(opened);
  ASSERT_EQ(shell("$f bake in/box1.obj -o one.glb -q --server " + older.url() + " --keep-failures kept"), 4)
      << err;
  EXPECT_THAT(err,
              AllOf(HasSubstr("in/box1.obj: unsound: "), HasSubstr("7 open edges"), HasSubstr("in kept")));
  EXPECT_FALSE(fs::exists(folder / "one.glb"));
  ASSERT_EQ(shell("$f bake in -o many -q --server " + older.url()), 4) << err;
  EXPECT_THAT(outputs(folder / "many"), IsEmpty());
  EXPECT_EQ(lines_in(folder / "many/bake.ndjson"), 4u);
  EXPECT_EQ(
      json::parse(bytes("many/bake.ndjson").substr(0, bytes("many/bake.ndjson").find('\n'))).at("status"),
      "unsound");

  // The kept failure consists of the mesh and the command. Without the tampering relay the command succeeds.
  const fs::directory_iterator kept(folder / "kept");
  const json request = json::parse(read_file(kept->path() / "request.json"));
  EXPECT_EQ(request.at("certificate").at("open_edges"), 7);
  const std::string command = request.at("command");
  ASSERT_THAT(command, StartsWith("fracture-server bake "));
  ASSERT_EQ(shell("cd '" + kept->path().string() + "' && \"$f\"" + command.substr(15)), 0) << err;
  ASSERT_EQ(shell("$f bake in/box1.obj -o direct.glb -q"), 0);
  EXPECT_EQ(read_file(kept->path() / "fragments.glb"), bytes("direct.glb"));
}

TEST_F(BakeProgram, AServersWordThatAnAnswerIsUnsoundIsExitCode4) {
  FakeServer server([](const FakeRequest& request) {
    const std::string kJson = "Content-Type: application/json\r\n";
    if (request.target == "/version")
      return FakeReply::answer(
          200, json{{"name", "fracture-server"}, {"algorithm", kAlgorithmVersion}}.dump(), kJson);
    if (request.target == "/limits") return FakeReply::answer(200, "{}", kJson);
    return FakeReply::answer(500,
                             R"({"type": "/problems/unsound", "title": "It is not.", "detail": "9 edges."})",
                             "Content-Type: application/problem+json\r\n");
  });
  const std::string url = " --server http://127.0.0.1:" + std::to_string(server.port());
  EXPECT_EQ(shell("$f bake in/box1.obj -o one.glb -q --allow-refused 9" + url), 4) << err;
  EXPECT_THAT(err, AllOf(HasSubstr("unsound: "), HasSubstr("9 edges.")));
  EXPECT_FALSE(fs::exists(folder / "one.glb"));
  EXPECT_EQ(shell("$f bake in -o many -q --allow-refused 9" + url), 4) << err;
  EXPECT_THAT(outputs(folder / "many"), IsEmpty());
  EXPECT_THAT(bytes("many/bake.ndjson"), HasSubstr("\"status\":\"unsound\""));
}

}  // namespace
}  // namespace fracture::test
